/* A belt that only an encoder measures: its counts, read once per cycle, become smooth set values for a slave axis.
 * Prints a line per cycle: count, set position (mm), velocity (mm/s), acceleration (mm/s^2).
 *
 *   cc -std=c11 -I../include encoder.c -lcoaxle -lm -o encoder && ./encoder 3
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "coaxle.h"

#define INCREMENT 0.01
#define CYCLE_S 0.001

/* The belt is at rest, gets to 500 mm/s within a second, and stays at that. */
static double belt(double t) {
  if (t < 0.5) return 0.0;
  if (t < 1.5) return 250.0 * (t - 0.5) * (t - 0.5);
  return 250.0 + 500.0 * (t - 1.5);
}

int main(int arguments, char **argument) {
  coaxle_encoder_parameters parameters = {.struct_size = sizeof parameters};
  coaxle_encoder *encoder;
  if (coaxle_encoder_parameters_init(&parameters, INCREMENT, 1000000) != COAXLE_OK ||
      coaxle_encoder_new(&parameters, &encoder) != COAXLE_OK) {
    fprintf(stderr, "%s\n", coaxle_last_error(NULL));
    return 1;
  }
  const int cycles = arguments > 1 ? atoi(argument[1]) * 1000 : 3000;
  for (int cycle = 0; cycle < cycles; cycle++) {
    double position = belt(cycle * CYCLE_S);
    coaxle_encoder_sample sample = {.count = (uint64_t)(int64_t)floor(position / INCREMENT), .cycles = 1};
    coaxle_encoder_state state = {.struct_size = sizeof state};
    /* The set values are of now: the count was read just before. */
    if (coaxle_encoder_update(encoder, &sample, 0.0, 1, &state) != COAXLE_OK) {
      fprintf(stderr, "%s\n", coaxle_last_error(encoder));
      return 1;
    }
    printf("%" PRIu64 " %.17g %.17g %.17g\n", sample.count, state.position, state.velocity, state.acceleration);
    if (cycle > 2500 && fabs(state.position - position) > INCREMENT) {
      fprintf(stderr, "%.6f mm at %.6f mm\n", state.position, position);
      return 1;
    }
  }
  coaxle_encoder_free(encoder);
  return 0;
}
