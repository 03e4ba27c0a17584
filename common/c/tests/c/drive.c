/* The memory of a drive from both ends: set values one way, actual values the other, and what happens when an end is gone. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "coaxle.h"

static int failures;

static void expect(int32_t received, int32_t wanted, const void *handle, int line) {
  if (received == wanted) return;
  fprintf(stderr, "line %d: received %" PRId32 " (%s), expected %" PRId32 "\n", line, received, coaxle_last_error(handle), wanted);
  failures += 1;
}
#define EXPECT(call, wanted, handle) expect((call), (wanted), (handle), __LINE__)

static void hold(int is_so, const char *what, int line) {
  if (is_so) return;
  fprintf(stderr, "line %d: %s\n", line, what);
  failures += 1;
}
#define HOLD(what) hold((what), #what, __LINE__)

/* Runs a cycle of the node, and returns the state of the drive. */
static uint32_t step(coaxle_drive_node *node, uint32_t wants_power, double position) {
  const coaxle_drive_memory_command command = {.struct_size = sizeof command,
                                               .wants_power = wants_power,
                                               .ideal_start_ns = 5000000,
                                               .elapsed_s = 0.001,
                                               .position = position,
                                               .velocity = 20.0};
  coaxle_actual actual = {.struct_size = sizeof actual};
  EXPECT(coaxle_drive_node_step(node, &command, &actual), COAXLE_OK, node);
  return actual.state;
}

/* Reads the set values, and reports a drive that is where they are. */
static coaxle_drive_set_values answer(coaxle_drive_process *process) {
  coaxle_drive_set_values set = {.struct_size = sizeof set};
  coaxle_drive_values values = {.struct_size = sizeof values};
  uint32_t is_attached = 0;
  EXPECT(coaxle_drive_process_read(process, &is_attached, &set), COAXLE_OK, process);
  HOLD(is_attached == 1);
  values.counter = set.counter;
  values.resets = set.resets;
  values.position = set.position;
  values.state = set.is_enabled ? COAXLE_PROCESS_FOLLOWING : COAXLE_PROCESS_OFF;
  EXPECT(coaxle_drive_process_report(process, &values), COAXLE_OK, process);
  return set;
}

static void refuse(const char *path, coaxle_drive_memory_parameters parameters) {
  coaxle_drive_node *node;
  coaxle_drive_process *process;
  EXPECT(coaxle_drive_process_new(path, &process), COAXLE_NOT_THERE, NULL);
  HOLD(strstr(coaxle_last_error(NULL), "start the receiver first") != NULL);
  EXPECT(coaxle_drive_process_new(NULL, &process), COAXLE_NULL, NULL);
  EXPECT(coaxle_drive_process_new("/dev/null", &process), COAXLE_REJECTED, NULL);
  parameters.following_error_window = -1.0;
  EXPECT(coaxle_drive_node_new(&parameters, path, "carriage", &node), COAXLE_REJECTED, NULL);
  parameters.cycle_time_ns = 1;
  EXPECT(coaxle_drive_node_new(&parameters, path, "carriage", &node), COAXLE_RANGE, NULL);
}

int main(int number, char **arguments) {
  const coaxle_drive_memory_parameters parameters = {.struct_size = sizeof parameters,
                                                     .axis_id = 3,
                                                     .run = 7,
                                                     .cycle_time_ns = 1000000,
                                                     .max_silent_cycles = 5,
                                                     .switch_on_cycles = 50,
                                                     .following_error_window = 10.0};
  coaxle_drive_node *node;
  coaxle_drive_process *process;
  const char *name = NULL;
  uint32_t axis_id = 0, is_attached = 1;
  int64_t cycle_time = 0;
  if (number != 2) return 2;
  refuse(arguments[1], parameters);

  EXPECT(coaxle_drive_node_new(&parameters, arguments[1], "carriage", &node), COAXLE_OK, NULL);
  EXPECT(coaxle_drive_process_new(arguments[1], &process), COAXLE_OK, NULL);
  EXPECT(coaxle_drive_process_slave(process, &name, &axis_id, &cycle_time), COAXLE_OK, process);
  HOLD(strcmp(name, "carriage") == 0 && axis_id == 3 && cycle_time == 1000000);

  HOLD(step(node, 0, 1.5) == COAXLE_DRIVE_OFF);
  HOLD(answer(process).is_enabled == 0);
  HOLD(step(node, 1, 1.5) == COAXLE_DRIVE_SWITCHING_ON);
  for (int n = 0; n < 3; n++) {
    const coaxle_drive_set_values set = answer(process);
    HOLD(set.is_enabled == 1 && set.position == 1.5 && set.velocity == 20.0 && set.ideal_start_ns == 5000000);
    (void)step(node, 1, 1.5);
  }
  HOLD(step(node, 1, 1.5) == COAXLE_DRIVE_FOLLOWING);

  /* Values that are none are not reported. */
  coaxle_drive_values values = {.struct_size = sizeof values, .state = 9};
  EXPECT(coaxle_drive_process_report(process, &values), COAXLE_RANGE, process);
  values.state = COAXLE_PROCESS_FOLLOWING;
  values.position = NAN;
  EXPECT(coaxle_drive_process_report(process, &values), COAXLE_RANGE, process);
  /* A process without a heartbeat trips the drive. */
  for (int n = 0; n < 8; n++) (void)step(node, 1, 1.5);
  HOLD(step(node, 1, 1.5) == COAXLE_DRIVE_TRIPPED);
  HOLD(step(node, 0, 1.5) == COAXLE_DRIVE_OFF);

  coaxle_drive_node_free(node);
  coaxle_drive_set_values set = {.struct_size = sizeof set};
  EXPECT(coaxle_drive_process_read(process, &is_attached, &set), COAXLE_NOT_THERE, process);
  HOLD(is_attached == 0);
  coaxle_drive_process_free(process);
  coaxle_drive_process_free(NULL);
  return failures != 0;
}
