/* The servo thread of LinuxCNC locked to a cycle elsewhere: that of a node of Coaxle, or the distributed clock of EtherCAT.
 * docs/LINUXCNC.md is the manual.
 *
 *   loadrt coaxle_lock
 *   net phase conveyor.phase-error-ns => coaxle-lock.phase-error-ns
 *   addf coaxle-lock servo-thread       # after what measures the phase
 *
 * The drift of the other cycle is the rate of its beginnings by the own clock, averaged; the cycle lock moves the deadlines of the thread
 * by drift and phase. A phase has no jitter of a network, so that it needs no observer of messages.
 */
#include <stdint.h>
#include <string.h>

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
MODULE_DESCRIPTION("The servo thread locked to a cycle elsewhere");
MODULE_LICENSE("Dual MIT/GPL");

static int period = 1000000;
RTAPI_MP_INT(period, "period of the servo thread, ns");
static int far_period = 0;
RTAPI_MP_INT(far_period, "period of the cycle elsewhere, ns; 0: that of the servo thread");

/* Time without a phase after which the drift is learned again, ns. */
#define LONGEST_GAP_NS 500000000
/* Time over which the drift is averaged, ns. A phase with 1 us of jitter leaves some ppm of it. */
#define AVERAGE_NS 500000000.0
/* Greatest drift of one sample, ppm: a jump of the phase must not count as a rate. */
#define MOST_DRIFT_PPM 1000.0
/* Samples until the average is used. */
#define FIRST_SAMPLES 1000

struct pins {
  /* In. */
  hal_bit_t *enable, *has_phase;
  hal_s32_t *phase_error_ns;
  /* Out. */
  hal_s32_t *correction_ns, *state;
  hal_bit_t *locked;
  hal_float_t *phase_ns, *drift_ppm, *period_ppm;
};

static struct {
  struct pins *pins;
  coaxle_cycle_lock *lock;
  /* Start of the newest cycle elsewhere by the own clock, and the drift of those cycles. */
  int64_t began;
  uint32_t samples;
  double drift_ppm;
} own;

static int component = -1;

/* Takes the cycle elsewhere that began half a period ago, but for the error of the phase. */
static void take_phase(int64_t now) {
  const int64_t began = now - far_period / 2 - *own.pins->phase_error_ns;
  const int64_t since = began - own.began;
  /* A phase is within a period: whole periods are in the time that has passed. */
  const int64_t cycles = (since + far_period / 2) / far_period;
  if (since > LONGEST_GAP_NS || since < -far_period) {
    own.samples = 0;
  } else if (cycles <= 0) {
    return;
  } else {
    const double nominal = (double)(cycles * far_period);
    const double sample = (nominal / (double)since - 1.0) * 1e6;
    const double bounded = sample > MOST_DRIFT_PPM ? MOST_DRIFT_PPM : sample < -MOST_DRIFT_PPM ? -MOST_DRIFT_PPM : sample;
    own.samples += own.samples < FIRST_SAMPLES;
    /* A plain average at first. */
    const double usual = nominal / AVERAGE_NS, first = 1.0 / own.samples;
    own.drift_ppm += (bounded - own.drift_ppm) * (usual > first ? usual : first);
  }
  own.began = began;
}

/* Returns by how much the next deadline is to be moved, ns. */
static int64_t advance(int64_t now) {
  int64_t moved = 0;
  if (*own.pins->has_phase) take_phase(now);
  const int is_known = *own.pins->has_phase && own.samples == FIRST_SAMPLES;
  const coaxle_far_phase phase = {.struct_size = sizeof phase,
                                  .age_s = (double)(now - own.began) * 1e-9,
                                  .drift_ppm = own.drift_ppm,
                                  .cycle_time_ns = far_period};
  (void)coaxle_cycle_lock_advance(own.lock, is_known ? &phase : NULL, 1, &moved);
  return moved;
}

static void show(int64_t moved) {
  uint32_t state = COAXLE_LOCK_WAITING;
  double phase_s = 0.0, period_ppm = 0.0;
  (void)coaxle_cycle_lock_state(own.lock, &state, &phase_s, &period_ppm);
  *own.pins->state = (hal_s32_t)state;
  *own.pins->locked = *own.pins->enable && state == COAXLE_LOCK_LOCKED;
  /* Not a number while the phase is not known. */
  *own.pins->phase_ns = phase_s == phase_s ? phase_s * 1e9 : 0.0;
  *own.pins->drift_ppm = own.drift_ppm;
  *own.pins->period_ppm = period_ppm;
  *own.pins->correction_ns = (hal_s32_t)moved;
}

/* The function `coaxle-lock`. */
static void lock_thread(void *nothing, long thread_period) {
  const int64_t now = rtapi_task_pll_get_reference();
  (void)nothing;
  /* A thread of another period, or one that cannot be moved, is left alone. */
  const int is_fit = now != 0 && thread_period > period - period / 100 && thread_period < period + period / 100;
  const int64_t moved = is_fit && *own.pins->enable ? advance(now) : 0;
  show(moved);
  if (!is_fit) *own.pins->state = COAXLE_LOCK_REFUSED;
  (void)rtapi_task_pll_set_correction((long)moved);
}

static int export_pins(struct pins *pins) {
  const struct {
    hal_type_t type;
    hal_pin_dir_t direction;
    void *place;
    const char *name;
  } all[] = {
      {HAL_BIT, HAL_IN, &pins->enable, "coaxle-lock.enable"},
      {HAL_BIT, HAL_IN, &pins->has_phase, "coaxle-lock.has-phase"},
      {HAL_S32, HAL_IN, &pins->phase_error_ns, "coaxle-lock.phase-error-ns"},
      {HAL_S32, HAL_OUT, &pins->correction_ns, "coaxle-lock.correction-ns"},
      {HAL_S32, HAL_OUT, &pins->state, "coaxle-lock.state"},
      {HAL_BIT, HAL_OUT, &pins->locked, "coaxle-lock.locked"},
      {HAL_FLOAT, HAL_OUT, &pins->phase_ns, "coaxle-lock.phase-ns"},
      {HAL_FLOAT, HAL_OUT, &pins->drift_ppm, "coaxle-lock.drift-ppm"},
      {HAL_FLOAT, HAL_OUT, &pins->period_ppm, "coaxle-lock.period-ppm"},
  };
  for (size_t n = 0; n < sizeof all / sizeof all[0]; n++) {
    const int code = hal_pin_new(all[n].name, all[n].type, all[n].direction, all[n].place, component);
    if (code < 0) return code;
  }
  *pins->enable = 1;
  *pins->has_phase = 1;
  return hal_export_funct("coaxle-lock", lock_thread, NULL, 1, 0, component);
}

static int is_period(const char *name, int received) {
  if (received >= 100000 && received <= 100000000) return 1;
  rtapi_print_msg(RTAPI_MSG_ERR, "coaxle_lock: %s: received %d, expected 100000 to 100000000 ns\n", name, received);
  return 0;
}

static int make_lock(void) {
  if (!is_period("period", period) || !is_period("far_period", far_period)) return -EINVAL;
  if (coaxle_cycle_lock_new(period, far_period / 2 % period, &own.lock) == COAXLE_OK) return 0;
  rtapi_print_msg(RTAPI_MSG_ERR, "coaxle_lock: %s\n", coaxle_last_error(NULL));
  return -EINVAL;
}

void rtapi_app_exit(void) {
  /* Takes the function out of its thread, which goes on with the last period. */
  hal_exit(component);
  coaxle_cycle_lock_free(own.lock);
}

int rtapi_app_main(void) {
  component = hal_init("coaxle_lock");
  if (component < 0) return component;
  if (far_period == 0) far_period = period;
  int code = make_lock();
  own.pins = hal_malloc(sizeof *own.pins);
  if (code >= 0 && own.pins == NULL) code = -ENOMEM;
  if (code >= 0) code = export_pins(own.pins);
  if (code < 0) {
    rtapi_app_exit();
    return code;
  }
  hal_ready(component);
  return 0;
}
