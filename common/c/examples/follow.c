/* Follows a far clock by a recording: FOLDER/NAME.i32 and FOLDER/NAME-exchanges.csv of common/clock/data/arrivals.
 * Prints a line per cycle: own time (ns), far time (ns), the rest beyond it (ns), greatest error (s), drift (ppm).
 *
 *   cc -std=c11 -I../include follow.c -lcoaxle -lm -o follow && ./follow ../../clock/data/arrivals udp-idle
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "coaxle.h"

#define CYCLE_NS INT64_C(1000000)

static void fail(const void *handle, const char *what, int32_t code) {
  fprintf(stderr, "%s: error %" PRId32 ": %s\n", what, code, coaxle_last_error(handle));
  exit(1);
}

static FILE *opened(const char *folder, const char *name, const char *end) {
  char path[512];
  snprintf(path, sizeof path, "%s/%s%s", folder, name, end);
  FILE *file = fopen(path, "rb");
  if (file == NULL) {
    perror(path);
    exit(1);
  }
  return file;
}

/* Reads the next exchange, if there is one. */
static int next_exchange(FILE *file, coaxle_time_response *response, int64_t *arrived) {
  static uint32_t number;
  number += 1;
  *response = (coaxle_time_response){.run = 1, .epoch = 1, .number = number};
  return fscanf(file, "%" SCNd64 ",%" SCNd64 ",%" SCNd64 ",%" SCNd64, &response->requested_ns, &response->received_ns,
                &response->responded_ns, arrived) == 4;
}

int main(int arguments, char **argument) {
  if (arguments != 3) {
    fprintf(stderr, "usage: follow FOLDER NAME\n");
    return 2;
  }
  FILE *messages = opened(argument[1], argument[2], ".i32");
  FILE *exchanges = opened(argument[1], argument[2], "-exchanges.csv");
  fscanf(exchanges, "%*[^\n]");

  coaxle_far_clock_parameters parameters = {
      .struct_size = sizeof parameters,
      .delay_source = COAXLE_DELAY_MEASURED,
      .cycle_time_ns = CYCLE_NS,
      .run = 1,
  };
  coaxle_far_clock *clock;
  int32_t code = coaxle_far_clock_new(&parameters, &clock);
  if (code != COAXLE_OK) fail(NULL, "coaxle_far_clock_new", code);

  coaxle_time_response response;
  int64_t response_at = 0;
  int has_response = next_exchange(exchanges, &response, &response_at);
  int32_t row[4];
  int64_t cycle = 0;
  while (fread(row, sizeof row, 1, messages) == 1) {
    const coaxle_message message = {
        .struct_size = sizeof message,
        .has_send_stamp = 1,
        .epoch = 1,
        .count = (uint64_t)row[0],
        .arrived_ns = row[0] * CYCLE_NS + row[1] + row[2],
        .send_stamp_ns = row[1],
    };
    /* Own cycles begin in the middle between those of the sender. */
    const int64_t due = (message.arrived_ns / CYCLE_NS) * CYCLE_NS + CYCLE_NS / 2;
    for (int64_t now = cycle == 0 ? due : cycle + CYCLE_NS; now < due; now += CYCLE_NS) {
      coaxle_far_time far = {.struct_size = sizeof far};
      uint32_t is_due, number;
      while (has_response && response_at <= now) {
        code = coaxle_far_clock_response(clock, response_at, &response);
        if (code != COAXLE_OK) fail(clock, "coaxle_far_clock_response", code);
        has_response = next_exchange(exchanges, &response, &response_at);
      }
      code = coaxle_far_clock_cycle(clock, now, &far);
      if (code != COAXLE_OK) fail(clock, "coaxle_far_clock_cycle", code);
      /* Requests went out when the recording was made; their numbers alone count here. */
      code = coaxle_far_clock_request(clock, now, &is_due, &number);
      if (code != COAXLE_OK) fail(clock, "coaxle_far_clock_request", code);
      cycle = now;
      if (far.is_sure)
        printf("%" PRId64 " %" PRId64 " %.17g %.17g %.17g\n", now, far.time_ns, far.fraction_ns, far.uncertainty_s, far.drift_ppm);
      else
        printf("%" PRId64 " -\n", now);
    }
    if (cycle == 0) cycle = due - CYCLE_NS;
    code = coaxle_far_clock_message(clock, &message);
    if (code != COAXLE_OK) fail(clock, "coaxle_far_clock_message", code);
  }
  coaxle_far_clock_free(clock);
  fclose(messages);
  fclose(exchanges);
  return 0;
}
