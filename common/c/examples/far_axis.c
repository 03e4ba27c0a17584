/* An axis of another PC in a loop of one's own: as received, moved to now by its clock, and shown 20 ms later as its frames state.
 * The far quartz is 200 ppm fast, every 50th frame is lost, and the rest take 150 to 250 us. Prints each way of following with the
 * largest difference from the truth (um) and the largest change of the velocity from one cycle to the next (mm/s).
 *
 *   cc -std=c11 -I../include far_axis.c -lcoaxle -lm -o far_axis && ./far_axis
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "coaxle.h"

#define CYCLE_NS INT64_C(1000000)
#define LATER_NS INT64_C(20000000)
#define SECONDS 30
#define SETTLED 15

enum { RECEIVED, NOW, LATER, WAYS };
static const char *const NAMES[WAYS] = {"as received", "moved to now", "shown later"};

static void check(const void *handle, const char *what, int32_t code) {
  if (code == COAXLE_OK) return;
  fprintf(stderr, "%s: error %d: %s\n", what, (int)code, coaxle_last_error(handle));
  exit(1);
}

/* The motion of the far axis by the far clock: a belt of 500 mm/s that sways by 5 mm, at 2.5 m/s^2. */
#define OMEGA 22.36
static double position(double t) { return 500.0 * t + 5.0 * sin(OMEGA * t); }
static double velocity(double t) { return 500.0 + 5.0 * OMEGA * cos(OMEGA * t); }
static double acceleration(double t) { return -5.0 * OMEGA * OMEGA * sin(OMEGA * t); }

/* Far time at an own time, s; and the own time of a far cycle, ns. */
#define RATE 1.0002
#define PHASE_S 0.0003
static double far_time(double own) { return (own - PHASE_S) * RATE; }
static int64_t own_ns(uint64_t count) { return (int64_t)llround(1e9 * ((double)count * 1e-3 / RATE + PHASE_S)); }

int main(void) {
  coaxle_far_clock_parameters of_clock = {.struct_size = sizeof of_clock,
                                          .delay_source = COAXLE_DELAY_FIXED,
                                          .cycle_time_ns = CYCLE_NS,
                                          .delay_ns = 150000,
                                          .run = 1};
  coaxle_far_clock *clock;
  check(NULL, "coaxle_far_clock_new", coaxle_far_clock_new(&of_clock, &clock));

  coaxle_far_axis *axes[WAYS];
  for (int way = 0; way < WAYS; way++) {
    coaxle_far_axis_parameters of_axis = {.struct_size = sizeof of_axis};
    check(NULL, "coaxle_far_axis_parameters_init", coaxle_far_axis_parameters_init(&of_axis, CYCLE_NS, CYCLE_NS));
    of_axis.mode = way == RECEIVED ? COAXLE_MODE_BYPASS : COAXLE_MODE_OBSERVER;
    check(NULL, "coaxle_far_axis_new", coaxle_far_axis_new(&of_axis, &axes[way]));
  }

  double worst[WAYS] = {0}, jump[WAYS] = {0}, before[WAYS][2] = {{0}};
  uint64_t count = 0, newest = 0;
  unsigned random = 1;
  int64_t arrives = own_ns(0) + 150000;
  for (int cycle = 1; cycle < SECONDS * 1000; cycle++) {
    const int64_t now = cycle * CYCLE_NS;
    for (; arrives <= now; count++, arrives = own_ns(count) + 150000 + (int64_t)((random = random * 1103515245u + 12345u) >> 16) % 100000) {
      if (count % 50 == 49) continue;
      const double t = (double)count * 1e-3;
      const coaxle_message message = {
          .struct_size = sizeof message, .has_send_stamp = 1, .epoch = 1, .count = count, .arrived_ns = arrives, .send_stamp_ns = 0};
      check(clock, "coaxle_far_clock_message", coaxle_far_clock_message(clock, &message));
      for (int way = 0; way < WAYS; way++) {
        const coaxle_far_sample sample = {.struct_size = sizeof sample,
                                          .count = count,
                                          .present_after_ns = way == LATER ? LATER_NS : 0,
                                          .position = position(t),
                                          .velocity = velocity(t),
                                          .acceleration = acceleration(t)};
        check(axes[way], "coaxle_far_axis_sample", coaxle_far_axis_sample(axes[way], &sample));
      }
      newest = count;
    }
    check(clock, "coaxle_far_clock_cycle", coaxle_far_clock_cycle(clock, now, NULL));
    double correction;
    const int32_t sure = coaxle_far_clock_correction(clock, newest, &correction);
    if (sure != COAXLE_NOT_THERE) check(clock, "coaxle_far_clock_correction", sure);
    for (int way = 0; way < WAYS; way++) {
      coaxle_far_axis_state state = {.struct_size = sizeof state};
      const int32_t code = coaxle_far_axis_cycle(axes[way], sure == COAXLE_OK ? &correction : NULL, 1, &state);
      if (code == COAXLE_NOT_THERE) continue;
      check(axes[way], "coaxle_far_axis_cycle", code);
      const double difference = state.position - before[way][0];
      if (cycle > SETTLED * 1000) {
        const double truth = position(far_time(cycle * 1e-3) - (way == LATER ? LATER_NS * 1e-9 : 0.0));
        worst[way] = fmax(worst[way], fabs(state.position - truth));
        jump[way] = fmax(jump[way], fabs(difference - before[way][1]) * 1e3);
      }
      before[way][0] = state.position;
      before[way][1] = difference;
    }
  }
  for (int way = 0; way < WAYS; way++) {
    printf("%-12s %8.1f um %8.1f mm/s\n", NAMES[way], worst[way] * 1e3, jump[way]);
    coaxle_far_axis_free(axes[way]);
  }
  coaxle_far_clock_free(clock);
  return 0;
}
