/* Axes of Coaxle as pins of LinuxCNC's HAL: set values of slaves of a receiver on the same machine, by the memory of a drive.
 * docs/LINUXCNC.md is the manual.
 *
 *   loadrt coaxle_axis names=conveyor,carriage paths=/dev/shm/coaxle-conveyor,/dev/shm/coaxle-carriage
 *   addf conveyor.read servo-thread     # at the beginning of the thread
 *   addf conveyor.write servo-thread    # at its end
 *
 * A thread of its own attaches to the memories, as that opens and maps files. A memory has one owner at a time: that thread until it
 * is attached, the servo thread until its node has ended, and then that thread again.
 */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_string.h"
#include "rtapi_errno.h"
#include "hal.h"

#include "coaxle.h"

#ifndef RTAPI_TASK_PLL_SUPPORT
#error "this LinuxCNC cannot move the cycles of its threads: version 2.9 or later is expected, not for a kernel of RTAI"
#endif

MODULE_AUTHOR("The authors of Coaxle");
MODULE_DESCRIPTION("Axes of Coaxle as pins, by the memory of a drive");
MODULE_LICENSE("Dual MIT/GPL");

#define MOST_AXES 16
#define ATTACH_INTERVAL_NS 100000000L

static char *names[MOST_AXES];
RTAPI_MP_ARRAY_STRING(names, MOST_AXES, "names of the axes, which their pins begin with");
static char *paths[MOST_AXES];
RTAPI_MP_ARRAY_STRING(paths, MOST_AXES, "the memory of each, as in the config of the receiver");

/* States of an axis. */
enum {
  WAITING = 0,   /* no node */
  OFF = 1,       /* the node requests no power */
  FOLLOWING = 2, /* position, velocity and acceleration are set values */
  SILENT = 3,    /* the node runs no cycles */
};

struct axis {
  /* Out: the set values. */
  hal_float_t *position, *velocity, *acceleration;
  hal_bit_t *ok;
  hal_s32_t *state;
  hal_u32_t *cycle;
  hal_u32_t *repeated, *missed;
  hal_float_t *time, *age;
  /* Out: the phase of the thread against the cycle of the node. */
  hal_s32_t *phase_error_ns;
  hal_bit_t *has_phase;
  hal_u32_t *node_cycle_ns;
  /* In. */
  hal_bit_t *bypass;
  hal_float_t *lead, *wanted_age, *max_age;
  /* In: the drive. */
  hal_bit_t *is_ready, *has_actual;
  hal_s32_t *error;
  hal_float_t *actual_position, *actual_velocity;

  const char *path;
  int32_t refused; /* the newest error of attaching that was reported */
  _Atomic(coaxle_drive_process *) attached; /* the servo thread's, until that sets it to NULL */
  _Atomic(coaxle_drive_process *) released; /* the attaching thread's */
  /* Of the servo thread alone. */
  coaxle_drive_set_values set; /* the newest; counter 0: none */
  int64_t node_cycle;
  int64_t fresh; /* instant at which the newest were first seen */
};

static int component = -1;
static struct axis *axes;
static int number;
static pthread_t attaching;
static int has_thread;
static atomic_int is_ending;

/* The start of the thread's cycle as it should be: its deadline, without the jitter of the system. */
static int64_t reference(void) {
  const int64_t start = rtapi_task_pll_get_reference();
  return start != 0 ? start : rtapi_get_time();
}

/* Returns the remainder of the nearest whole number of periods: within half a period of 0. */
static int64_t within_half(int64_t of, int64_t period) {
  int64_t rest = of % period;
  if (rest > period / 2) rest -= period;
  if (rest < -(period / 2)) rest += period;
  return rest;
}

static void forget(struct axis *axis) {
  memset(&axis->set, 0, sizeof axis->set);
}

/* Takes new set values, and counts those that were seen twice or never. */
static void take(struct axis *axis, const coaxle_drive_set_values *set, int64_t now) {
  const int has_both = axis->set.counter != 0 && axis->set.is_enabled && set->is_enabled;
  if (set->counter == axis->set.counter) {
    if (has_both) *axis->repeated += 1;
    return;
  }
  if (has_both) *axis->missed += (hal_u32_t)(set->counter - axis->set.counter - 1);
  axis->set = *set;
  axis->fresh = now;
}

static void show_phase(struct axis *axis, int64_t now) {
  const int64_t age = now - axis->set.ideal_start_ns;
  const int64_t cycle = axis->node_cycle > 0 ? axis->node_cycle : 1000000;
  const double wanted = *axis->wanted_age > 0 ? *axis->wanted_age * 1e9 : 0.5 * (double)cycle;
  *axis->age = (double)age * 1e-9;
  *axis->node_cycle_ns = (hal_u32_t)cycle;
  *axis->phase_error_ns = (hal_s32_t)within_half(age - (int64_t)wanted, cycle);
  *axis->has_phase = 1;
}

/* Shows the set values at the start of the thread's cycle: those of the node's cycle are of another instant. */
static void show_values(struct axis *axis, int64_t now) {
  const coaxle_drive_set_values *set = &axis->set;
  const double ahead = *axis->bypass ? 0.0 : (double)(now - set->ideal_start_ns) * 1e-9 + *axis->lead;
  *axis->position = set->position + (set->velocity + 0.5 * set->acceleration * ahead) * ahead;
  *axis->velocity = set->velocity + set->acceleration * ahead;
  *axis->acceleration = set->acceleration;
}

/* Shows that there are no set values. Without power a drive is where it is. */
static void show_none(struct axis *axis, int state) {
  *axis->ok = 0;
  *axis->state = state;
  *axis->velocity = 0.0;
  *axis->acceleration = 0.0;
  if (*axis->has_actual) *axis->position = *axis->actual_position;
}

static void show(struct axis *axis, int64_t now) {
  const int is_fresh = (double)(now - axis->fresh) * 1e-9 <= *axis->max_age;
  *axis->time = (double)now * 1e-9;
  *axis->cycle = (hal_u32_t)axis->set.counter;
  *axis->has_phase = 0;
  if (axis->set.counter == 0) return show_none(axis, WAITING);
  if (!is_fresh) return show_none(axis, SILENT);
  show_phase(axis, now);
  if (!axis->set.is_enabled) return show_none(axis, OFF);
  *axis->ok = 1;
  *axis->state = FOLLOWING;
  show_values(axis, now);
}

/* The function `read`. */
static void read_axis(void *of, long period) {
  struct axis *axis = of;
  const int64_t now = reference();
  coaxle_drive_process *memory = atomic_load_explicit(&axis->attached, memory_order_acquire);
  (void)period;
  if (memory == NULL) {
    forget(axis);
  } else {
    coaxle_drive_set_values set = {.struct_size = sizeof set};
    uint32_t is_attached = 0;
    if (axis->set.counter == 0) (void)coaxle_drive_process_slave(memory, NULL, NULL, &axis->node_cycle);
    /* Those that are being written just now are read in the next cycle: the previous ones go on. */
    if (coaxle_drive_process_read(memory, &is_attached, &set) == COAXLE_OK) take(axis, &set, now);
    if (!is_attached) {
      forget(axis);
      atomic_store_explicit(&axis->attached, NULL, memory_order_relaxed);
      atomic_store_explicit(&axis->released, memory, memory_order_release);
    }
  }
  show(axis, now);
}

/* The function `write`: reports the drive to the node. */
static void write_axis(void *of, long period) {
  struct axis *axis = of;
  coaxle_drive_process *memory = atomic_load_explicit(&axis->attached, memory_order_acquire);
  coaxle_drive_values values = {.struct_size = sizeof values};
  (void)period;
  if (memory == NULL) return;
  values.counter = axis->set.counter;
  values.resets = axis->set.resets;
  values.position = *axis->has_actual ? *axis->actual_position : axis->set.position;
  values.velocity = *axis->has_actual ? *axis->actual_velocity : *axis->velocity;
  values.error = (uint32_t)*axis->error;
  values.state = COAXLE_PROCESS_OFF;
  if (*axis->ok && *axis->is_ready) values.state = COAXLE_PROCESS_FOLLOWING;
  if (*axis->error != 0) values.state = COAXLE_PROCESS_ERROR;
  /* Actual values that are no numbers are not reported: their heartbeat is missing, and the node stops the slave. */
  (void)coaxle_drive_process_report(memory, &values);
}

static void attach(struct axis *axis) {
  coaxle_drive_process *memory = atomic_exchange_explicit(&axis->released, NULL, memory_order_acquire);
  if (memory != NULL) {
    rtapi_print_msg(RTAPI_MSG_INFO, "coaxle_axis: %s: its node has ended\n", axis->path);
    coaxle_drive_process_free(memory);
  }
  if (atomic_load_explicit(&axis->attached, memory_order_relaxed) != NULL) return;
  const int32_t code = coaxle_drive_process_new(axis->path, &memory);
  const int is_new = code != axis->refused;
  axis->refused = code;
  if (code == COAXLE_OK) {
    atomic_store_explicit(&axis->attached, memory, memory_order_release);
    rtapi_print_msg(RTAPI_MSG_INFO, "coaxle_axis: attached to %s\n", axis->path);
  } else if (code != COAXLE_NOT_THERE && is_new) {
    /* No node yet is usual; a file that is something else is a mistake, and is named once. */
    rtapi_print_msg(RTAPI_MSG_ERR, "coaxle_axis: %s\n", coaxle_last_error(NULL));
  }
}

static void *attach_all(void *nothing) {
  const struct timespec interval = {.tv_sec = 0, .tv_nsec = ATTACH_INTERVAL_NS};
  while (!atomic_load(&is_ending)) {
    for (int n = 0; n < number; n++) attach(&axes[n]);
    nanosleep(&interval, NULL);
  }
  return nothing;
}

/* Starts the attaching thread, which must not have the priority of the one that loads modules. */
static int start_thread(void) {
  const struct sched_param lowest = {.sched_priority = 0};
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return -ENOMEM;
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
  pthread_attr_setschedparam(&attributes, &lowest);
  has_thread = pthread_create(&attaching, &attributes, attach_all, NULL) == 0;
  pthread_attr_destroy(&attributes);
  return has_thread ? 0 : -EAGAIN;
}

struct pin {
  hal_type_t type;
  hal_pin_dir_t direction;
  size_t field;
  const char *name;
};

#define PIN(type, direction, field, name) {type, direction, offsetof(struct axis, field), name}

static const struct pin PINS[] = {
    PIN(HAL_FLOAT, HAL_OUT, position, "position"),
    PIN(HAL_FLOAT, HAL_OUT, velocity, "velocity"),
    PIN(HAL_FLOAT, HAL_OUT, acceleration, "acceleration"),
    PIN(HAL_BIT, HAL_OUT, ok, "ok"),
    PIN(HAL_S32, HAL_OUT, state, "state"),
    PIN(HAL_U32, HAL_OUT, cycle, "cycle"),
    PIN(HAL_U32, HAL_OUT, repeated, "repeated"),
    PIN(HAL_U32, HAL_OUT, missed, "missed"),
    PIN(HAL_FLOAT, HAL_OUT, time, "time"),
    PIN(HAL_FLOAT, HAL_OUT, age, "age"),
    PIN(HAL_S32, HAL_OUT, phase_error_ns, "phase-error-ns"),
    PIN(HAL_BIT, HAL_OUT, has_phase, "has-phase"),
    PIN(HAL_U32, HAL_OUT, node_cycle_ns, "node-cycle-ns"),
    PIN(HAL_BIT, HAL_IN, bypass, "bypass"),
    PIN(HAL_FLOAT, HAL_IN, lead, "lead"),
    PIN(HAL_FLOAT, HAL_IN, wanted_age, "wanted-age"),
    PIN(HAL_FLOAT, HAL_IN, max_age, "max-age"),
    PIN(HAL_BIT, HAL_IN, is_ready, "drive-ready"),
    PIN(HAL_BIT, HAL_IN, has_actual, "has-actual"),
    PIN(HAL_S32, HAL_IN, error, "drive-error"),
    PIN(HAL_FLOAT, HAL_IN, actual_position, "actual-position"),
    PIN(HAL_FLOAT, HAL_IN, actual_velocity, "actual-velocity"),
};

static int export_pins(struct axis *axis, const char *name) {
  for (size_t n = 0; n < sizeof PINS / sizeof PINS[0]; n++) {
    const struct pin *pin = &PINS[n];
    char full[HAL_NAME_LEN + 1];
    const int length = rtapi_snprintf(full, sizeof full, "%s.%s", name, pin->name);
    if (length >= (int)sizeof full) return -EINVAL;
    void **place = (void **)((char *)axis + pin->field);
    const int code = hal_pin_new(full, pin->type, pin->direction, place, component);
    if (code < 0) return code;
  }
  *axis->is_ready = 1;
  *axis->max_age = 0.02;
  return 0;
}

static int export_functions(struct axis *axis, const char *name) {
  static const struct {
    const char *name;
    void (*function)(void *, long);
  } FUNCTIONS[] = {{"read", read_axis}, {"write", write_axis}};
  for (int n = 0; n < 2; n++) {
    char full[HAL_NAME_LEN + 1];
    rtapi_snprintf(full, sizeof full, "%s.%s", name, FUNCTIONS[n].name);
    const int code = hal_export_funct(full, FUNCTIONS[n].function, axis, 1, 0, component);
    if (code < 0) return code;
  }
  return 0;
}

static int count_axes(void) {
  while (number < MOST_AXES && names[number] != NULL) number++;
  for (int n = 0; n < MOST_AXES; n++) {
    if ((n < number) != (paths[n] != NULL)) {
      rtapi_print_msg(RTAPI_MSG_ERR, "coaxle_axis: paths: received another number than %d, expected one for each of names=\n", number);
      return -EINVAL;
    }
  }
  if (number == 0) rtapi_print_msg(RTAPI_MSG_ERR, "coaxle_axis: names: received none, expected 1 to %d\n", MOST_AXES);
  return number > 0 ? 0 : -EINVAL;
}

static int begin(void) {
  int code = count_axes();
  if (code < 0) return code;
  axes = hal_malloc((long)((size_t)number * sizeof *axes));
  if (axes == NULL) return -ENOMEM;
  memset(axes, 0, (size_t)number * sizeof *axes);
  for (int n = 0; n < number; n++) {
    axes[n].path = paths[n];
    code = export_pins(&axes[n], names[n]);
    if (code >= 0) code = export_functions(&axes[n], names[n]);
    if (code < 0) {
      rtapi_print_msg(RTAPI_MSG_ERR, "coaxle_axis: names: received %s, expected a short name of its own\n", names[n]);
      return code;
    }
  }
  return start_thread();
}

void rtapi_app_exit(void) {
  atomic_store(&is_ending, 1);
  if (has_thread) pthread_join(attaching, NULL);
  /* Takes the functions out of their threads: nobody uses the memories any more. */
  hal_exit(component);
  for (int n = 0; n < number && axes != NULL; n++) {
    coaxle_drive_process_free(atomic_load(&axes[n].attached));
    coaxle_drive_process_free(atomic_load(&axes[n].released));
  }
}

int rtapi_app_main(void) {
  component = hal_init("coaxle_axis");
  if (component < 0) return component;
  const int code = begin();
  if (code < 0) {
    rtapi_app_exit();
    return code;
  }
  hal_ready(component);
  return 0;
}
