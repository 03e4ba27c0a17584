/* A flying saw in a loop of one's own: a conveyor in, set values for a drive out, cut after cut.
 *
 *   cc -std=c11 -I../include saw.c -lcoaxle -lm -o saw && ./saw 5
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "coaxle.h"

#define CYCLE_S 0.001
#define LENGTH 1000.0   /* of the pieces, mm */
#define SYNCHRONOUS 150.0
#define CUT_S 0.4

static coaxle_slave *saw;
static coaxle_slave_state state = {.struct_size = sizeof state};
static coaxle_master conveyor = {.velocity = 500.0, .is_there = 1};

static void check(int32_t code, const char *what) {
  if (code == COAXLE_OK) return;
  fprintf(stderr, "%s: error %" PRId32 ": %s\n", what, code, coaxle_last_error(saw));
  exit(1);
}

static coaxle_command command_of(uint32_t kind) {
  coaxle_command command = {.struct_size = sizeof command};
  check(coaxle_command_init(&command, kind), "coaxle_command_init");
  return command;
}

static uint32_t execute(const coaxle_command *command) {
  uint32_t job = 0;
  check(coaxle_slave_execute(saw, NULL, command, &job), "coaxle_slave_execute");
  return job;
}

/* One cycle of one's own loop: here the conveyor is calculated, and the set values go nowhere. */
static void cycle(void) {
  conveyor.position += conveyor.velocity * CYCLE_S;
  check(coaxle_slave_update(saw, NULL, &conveyor, 1, CYCLE_S, &state), "coaxle_slave_update");
}

static void wait_for(uint32_t job, uint32_t wanted) {
  uint32_t is = COAXLE_JOB_NONE, error = 0;
  for (int n = 0; n < 100000; n++) {
    cycle();
    check(coaxle_slave_job(saw, job, &is, &error), "coaxle_slave_job");
    if (is == wanted) return;
    if (is == COAXLE_JOB_FAILED || is == COAXLE_JOB_ABORTED) break;
  }
  fprintf(stderr, "job %" PRIu32 " is %" PRIu32 ", error 0x%" PRIx32 "\n", job, is, error);
  exit(1);
}

int main(int arguments, char **argument) {
  const int cuts = arguments > 1 ? atoi(argument[1]) : 3;
  const coaxle_slave_parameters parameters = {
      .struct_size = sizeof parameters,
      .flags = COAXLE_HAS_MIN_POSITION | COAXLE_HAS_MAX_POSITION,
      .cycle_time_ns = 1000000,
      .velocity = 2000.0,
      .acceleration = 10000.0,
      .jerk = 500000.0,
      .min_position = -10.0,
      .max_position = 900.0,
  };
  const int32_t code = coaxle_slave_new(&parameters, &saw);
  if (code != COAXLE_OK) {
    fprintf(stderr, "coaxle_slave_new: error %" PRId32 ": %s\n", code, coaxle_last_error(NULL));
    return 1;
  }
  coaxle_command power = command_of(COAXLE_POWER_ON);
  execute(&power);
  cycle();
  for (int n = 1; n <= cuts; n++) {
    coaxle_command cut = command_of(COAXLE_GEAR_IN_POS);
    cut.master_sync_position = n * LENGTH;
    cut.slave_sync_position = SYNCHRONOUS;
    /* It waits at rest, and begins 300 mm before. */
    cut.flags = COAXLE_HAS_MASTER_START_DISTANCE;
    cut.master_start_distance = 300.0;
    /* A dry run first: it changes nothing. */
    check(coaxle_slave_plan(saw, NULL, &cut), "coaxle_slave_plan");
    wait_for(execute(&cut), COAXLE_JOB_IN_SYNC);
    const double place = conveyor.position - (state.position - SYNCHRONOUS);
    double slip = 0.0;
    for (int left = (int)(CUT_S / CYCLE_S); left > 0; left--) {
      cycle();
      slip = fmax(slip, fabs(conveyor.position - (state.position - SYNCHRONOUS) - place));
    }
    printf("cut %d at %.6f mm, slip %.2g mm\n", n, place, slip);
    if (fabs(place - n * LENGTH) > 1e-6 || slip > 1e-6) return 1;
    coaxle_command back = command_of(COAXLE_MOVE_ABSOLUTE);
    back.position = 0.0;
    wait_for(execute(&back), COAXLE_JOB_DONE);
  }
  /* What is impossible is refused with a code of the NC and a sentence, and changes nothing. */
  coaxle_command beyond = command_of(COAXLE_MOVE_ABSOLUTE);
  beyond.position = 1000.0;
  const int32_t refused = coaxle_slave_plan(saw, NULL, &beyond);
  printf("refused: 0x%" PRIx32 ": %s\n", (uint32_t)refused, coaxle_last_error(saw));
  coaxle_slave_free(saw);
  return refused == COAXLE_OK;
}
