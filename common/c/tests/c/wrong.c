/* Whatever a caller does wrong and can be seen is an error code and a sentence. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "coaxle.h"

static int failures;

static void expect(int32_t received, int32_t wanted, const void *handle, const char *part, int line) {
  const char *sentence = coaxle_last_error(handle);
  if (received != wanted || strstr(sentence, part) == NULL) {
    fprintf(stderr, "line %d: received %" PRId32 " (%s), expected %" PRId32 " (%s)\n", line, received, sentence, wanted, part);
    failures += 1;
  }
}
#define EXPECT(call, wanted, handle, part) expect((call), (wanted), (handle), (part), __LINE__)

int main(void) {
  coaxle_far_clock_parameters parameters = {.struct_size = sizeof parameters, .cycle_time_ns = 1000000};
  coaxle_far_clock *clock = (coaxle_far_clock *)&failures;

  if (coaxle_abi_version() < COAXLE_ABI_VERSION) failures += 1;
  EXPECT(coaxle_far_clock_new(NULL, &clock), COAXLE_NULL, NULL, "coaxle_far_clock_parameters");
  if (clock != NULL) failures += 1;
  EXPECT(coaxle_far_clock_new(&parameters, NULL), COAXLE_NULL, NULL, "out");
  parameters.struct_size = 8;
  EXPECT(coaxle_far_clock_new(&parameters, &clock), COAXLE_STRUCT_SIZE, NULL, "32");
  parameters.struct_size = 0xFFFFFFFF;
  EXPECT(coaxle_far_clock_new(&parameters, &clock), COAXLE_STRUCT_SIZE, NULL, "32");
  parameters.struct_size = sizeof parameters;
  parameters.cycle_time_ns = 5;
  EXPECT(coaxle_far_clock_new(&parameters, &clock), COAXLE_RANGE, NULL, "cycle_time_ns: received 5");
  parameters.cycle_time_ns = 1000000;
  parameters.delay_source = 9;
  EXPECT(coaxle_far_clock_new(&parameters, &clock), COAXLE_RANGE, NULL, "delay_source");
  parameters.delay_source = COAXLE_DELAY_FIXED;
  parameters.delay_ns = INT64_MIN;
  EXPECT(coaxle_far_clock_new(&parameters, &clock), COAXLE_RANGE, NULL, "delay_ns");

  /* A struct of a newer header: what this library does not know must be 0. */
  struct {
    coaxle_far_clock_parameters known;
    uint64_t unknown;
  } newer = {.known = {.struct_size = sizeof newer, .cycle_time_ns = 1000000}, .unknown = 1};
  EXPECT(coaxle_far_clock_new(&newer.known, &clock), COAXLE_STRUCT_SIZE, NULL, "zeros");
  newer.unknown = 0;
  EXPECT(coaxle_far_clock_new(&newer.known, &clock), COAXLE_OK, NULL, "");

  EXPECT(coaxle_far_clock_message(NULL, NULL), COAXLE_NULL, NULL, "coaxle_far_clock");
  EXPECT(coaxle_far_clock_message(clock, NULL), COAXLE_NULL, clock, "coaxle_message");
  char memory[2 * sizeof(coaxle_message)];
  memset(memory, 0, sizeof memory);
  EXPECT(coaxle_far_clock_message(clock, (coaxle_message *)(void *)(memory + 1)), COAXLE_MISALIGNED, clock, "multiple");
  EXPECT(coaxle_far_clock_message((coaxle_far_clock *)(void *)((char *)clock + 1), NULL), COAXLE_MISALIGNED, NULL, "multiple");
  double seconds;
  EXPECT(coaxle_far_clock_correction(clock, 0, &seconds), COAXLE_NOT_THERE, clock, "not sure");
  /* A handle of another kind. */
  coaxle_cycle_lock *lock = NULL;
  int64_t moved;
  EXPECT(coaxle_cycle_lock_new(1000000, 1000000, &lock), COAXLE_RANGE, NULL, "offset_ns");
  EXPECT(coaxle_cycle_lock_new(1000000, 0, &lock), COAXLE_OK, NULL, "");
  EXPECT(coaxle_cycle_lock_advance((coaxle_cycle_lock *)(void *)clock, NULL, 1, &moved), COAXLE_NO_HANDLE, NULL, "another kind");
  coaxle_far_phase phase = {.struct_size = sizeof phase, .age_s = NAN, .cycle_time_ns = 1000000};
  EXPECT(coaxle_cycle_lock_advance(lock, &phase, 1, &moved), COAXLE_RANGE, lock, "age_s");
  EXPECT(coaxle_cycle_lock_advance(lock, NULL, 1, NULL), COAXLE_NULL, lock, "moved_ns");
  EXPECT(coaxle_cycle_lock_advance(lock, NULL, 1, &moved), COAXLE_OK, lock, "moved_ns");
  coaxle_cycle_lock_free(lock);
  coaxle_far_clock_free(clock);
  coaxle_far_clock_free(NULL);

  coaxle_far_axis_parameters of_axis = {.struct_size = 4};
  coaxle_far_axis *followed;
  EXPECT(coaxle_far_axis_parameters_init(&of_axis, 1000000, 0), COAXLE_STRUCT_SIZE, NULL, "136");
  of_axis.struct_size = sizeof of_axis;
  EXPECT(coaxle_far_axis_parameters_init(&of_axis, 5, 0), COAXLE_OK, NULL, "");
  EXPECT(coaxle_far_axis_new(&of_axis, &followed), COAXLE_RANGE, NULL, "cycle_time_ns: received 5");
  EXPECT(coaxle_far_axis_parameters_init(&of_axis, 1000000, 0), COAXLE_OK, NULL, "");
  of_axis.mode = COAXLE_MODE_SYNC;
  EXPECT(coaxle_far_axis_new(&of_axis, &followed), COAXLE_RANGE, NULL, "mode: received 3");
  of_axis.mode = COAXLE_MODE_OBSERVER;
  of_axis.blending_time_s = NAN;
  EXPECT(coaxle_far_axis_new(&of_axis, &followed), 0x4b56, NULL, "blending-time-s");
  of_axis.blending_time_s = 0.06;
  of_axis.age_of_data_limit = 70000;
  EXPECT(coaxle_far_axis_new(&of_axis, &followed), COAXLE_RANGE, NULL, "age_of_data_limit: received 70000");
  of_axis.age_of_data_limit = COAXLE_AGE_BY_DEFAULT;
  EXPECT(coaxle_far_axis_new(&of_axis, &followed), COAXLE_OK, NULL, "");
  EXPECT(coaxle_far_axis_cycle(followed, NULL, 1, NULL), COAXLE_NOT_THERE, followed, "no sample");
  coaxle_far_sample of_far = {.struct_size = sizeof of_far, .count = UINT64_MAX};
  EXPECT(coaxle_far_axis_sample(followed, &of_far), COAXLE_RANGE, followed, "count");
  of_far.count = 1;
  of_far.velocity = INFINITY;
  EXPECT(coaxle_far_axis_sample(followed, &of_far), COAXLE_RANGE, followed, "velocity");
  of_far.velocity = 0;
  of_far.present_after_ns = -1;
  EXPECT(coaxle_far_axis_sample(followed, &of_far), COAXLE_RANGE, followed, "present_after_ns");
  of_far.present_after_ns = 0;
  EXPECT(coaxle_far_axis_sample(followed, &of_far), COAXLE_OK, followed, "");
  seconds = NAN;
  EXPECT(coaxle_far_axis_cycle(followed, &seconds, 1, NULL), COAXLE_RANGE, followed, "correction_s");
  EXPECT(coaxle_far_axis_plan(followed, NULL), COAXLE_NULL, followed, "plan");
  EXPECT(coaxle_far_axis_cycle(followed, NULL, 1, NULL), COAXLE_OK, followed, "");
  coaxle_far_axis_free(followed);

  coaxle_encoder_parameters of_encoder = {.struct_size = 4};
  coaxle_encoder *encoder;
  EXPECT(coaxle_encoder_parameters_init(&of_encoder, 0.01, 1000000), COAXLE_STRUCT_SIZE, NULL, "88");
  of_encoder.struct_size = sizeof of_encoder;
  EXPECT(coaxle_encoder_parameters_init(&of_encoder, NAN, 1000000), COAXLE_OK, NULL, "");
  EXPECT(coaxle_encoder_new(&of_encoder, &encoder), 0x4b56, NULL, "increment");
  of_encoder.increment = 0.01;
  of_encoder.counter_bits = 300;
  EXPECT(coaxle_encoder_new(&of_encoder, &encoder), COAXLE_RANGE, NULL, "counter_bits: received 300");
  of_encoder.counter_bits = 64;
  EXPECT(coaxle_encoder_new(&of_encoder, &encoder), COAXLE_OK, NULL, "");
  EXPECT(coaxle_encoder_update(encoder, NULL, NAN, 1, NULL), COAXLE_RANGE, encoder, "horizon_s");
  EXPECT(coaxle_encoder_update(encoder, NULL, 0.0, 1, NULL), COAXLE_OK, encoder, "");
  coaxle_encoder_free(encoder);

  coaxle_key *key;
  EXPECT(coaxle_key_new("\xFF", &key), COAXLE_TEXT, NULL, "byte 0");
  EXPECT(coaxle_key_new("coaxle/a/axes", &key), COAXLE_OK, NULL, "");
  uint32_t id;
  EXPECT(coaxle_sender_id("a/b", &id), COAXLE_TEXT, NULL, "a/b");
  coaxle_frame_header header = {.struct_size = sizeof header, .cycle_time_ns = 1000000};
  coaxle_axis axis = {.axis_id = 1, .set_position = NAN};
  uint8_t bytes[COAXLE_MOST_BYTES];
  size_t length = 0, number = 0;
  EXPECT(coaxle_frame_encode(key, &header, &axis, 1, bytes, sizeof bytes, &length), COAXLE_RANGE, key, "fPosSoll");
  axis.set_position = 2.5;
  EXPECT(coaxle_frame_encode(key, &header, &axis, 129, bytes, sizeof bytes, &length), COAXLE_RANGE, key, "128");
  EXPECT(coaxle_frame_encode(key, &header, &axis, 1, bytes, 3, &length), COAXLE_CAPACITY, key, "at least");
  EXPECT(coaxle_frame_encode(key, &header, &axis, 1, bytes, sizeof bytes, &length), COAXLE_OK, key, "");
  for (size_t cut = 0; cut < length; cut++) {
    coaxle_axis found;
    EXPECT(coaxle_frame_decode(key, bytes, cut, &header, &found, 1, &number), COAXLE_REJECTED, key, "");
    bytes[cut] ^= 0x40;
    EXPECT(coaxle_frame_decode(key, bytes, length, &header, &found, 1, &number), COAXLE_REJECTED, key, "");
    bytes[cut] ^= 0x40;
  }
  axis.set_position = 0.0;
  EXPECT(coaxle_frame_decode(key, bytes, length, &header, &axis, 1, &number), COAXLE_OK, key, "");
  if (number != 1 || axis.set_position != 2.5) failures += 1;
  coaxle_key_free(key);

  coaxle_slave_parameters of_slave = {.struct_size = sizeof of_slave, .cycle_time_ns = 1000000, .velocity = -1.0};
  coaxle_slave *slave;
  EXPECT(coaxle_slave_new(&of_slave, &slave), COAXLE_RANGE, NULL, "velocity: received -1");
  of_slave.velocity = of_slave.acceleration = 100.0;
  EXPECT(coaxle_slave_new(&of_slave, &slave), COAXLE_OK, NULL, "");
  coaxle_command command = {.struct_size = sizeof command};
  EXPECT(coaxle_command_init(&command, 99), COAXLE_OK, NULL, "");
  EXPECT(coaxle_slave_plan(slave, NULL, &command), COAXLE_RANGE, slave, "kind: received 99");
  EXPECT(coaxle_command_init(&command, COAXLE_MOVE_ABSOLUTE), COAXLE_OK, NULL, "");
  EXPECT(coaxle_slave_execute(slave, NULL, &command, NULL), 0x422a, slave, "");
  /* What cannot be passed out is not done either. */
  uint32_t jobs[2];
  EXPECT(coaxle_command_init(&command, COAXLE_POWER_ON), COAXLE_OK, NULL, "");
  EXPECT(coaxle_slave_execute(slave, NULL, &command, (uint32_t *)(void *)((char *)jobs + 1)), COAXLE_MISALIGNED, slave, "job");
  coaxle_slave_state state = {.struct_size = sizeof state};
  EXPECT(coaxle_slave_update(slave, NULL, NULL, 0, 0.001, &state), COAXLE_OK, slave, "");
  if (state.status != COAXLE_DISABLED || state.wants_power != 0) failures += 1;
  EXPECT(coaxle_slave_update(slave, NULL, NULL, 1, 0.001, NULL), COAXLE_NULL, slave, "masters");
  EXPECT(coaxle_slave_update(slave, NULL, NULL, 0, NAN, NULL), COAXLE_RANGE, slave, "elapsed_s");
  coaxle_actual actual = {.struct_size = sizeof actual};
  EXPECT(coaxle_slave_report_actual(slave, &actual), COAXLE_RANGE, slave, "ideal");
  double values[31];
  EXPECT(coaxle_slave_saw_characteristics(slave, values), COAXLE_NOT_THERE, slave, "no flying saw");
  coaxle_slave_free(slave);

  coaxle_tables *tables;
  EXPECT(coaxle_tables_new(0, &tables), COAXLE_RANGE, NULL, "capacity");
  EXPECT(coaxle_tables_new(2, &tables), COAXLE_OK, NULL, "");
  EXPECT(coaxle_tables_add_points(tables, 1, 1, NULL, 3), COAXLE_NULL, tables, "points");
  EXPECT(coaxle_tables_add_file(tables, 1, "a.toml", "title = 3"), COAXLE_TEXT, tables, "a.toml");
  EXPECT(coaxle_tables_at(tables, 7, 0.0, values), 0x4216, tables, "7");
  coaxle_tables_free(tables);

  coaxle_receiver_parameters of_receiver = {.struct_size = sizeof of_receiver};
  coaxle_receiver *receiver;
  EXPECT(coaxle_receiver_new(&of_receiver, "a.toml", "name = 3", &receiver), COAXLE_TEXT, NULL, "a.toml");
  return failures != 0;
}
