/* A receiver over UDP in a loop of one's own: a master and a receiver in one program, as two ends of a socket of loopback.
 * Each datagram is the time at which it left (as a kernel would stamp it), the key of a message, a 0, and the message. The loop runs in
 * calculated time: a real one sleeps until each cycle, and takes stamps of its clock. The master's quartz is 200 ppm slow.
 *
 *   cc -std=c11 -I../include receiver.c -lcoaxle -lm -o receiver && ./receiver
 */
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "coaxle.h"

#define CYCLE_NS INT64_C(1000000)
#define DRIFT 200e-6
#define WAY_NS INT64_C(200000)  /* of each datagram */
#define LATE_NS INT64_C(30000)  /* the master sends so much after the start of its cycle */

static const char *const CONFIG =
    "name = \"station\"\n"
    "cycle-time-us = 1000\n"
    "master = { node = \"conveyor\" }\n"
    "[[slave]]\n"
    "name = \"carriage\"\n"
    "gear = { ratio = 0.5, offset = 0.0 }\n";

static void check(const void *handle, int32_t code, const char *what) {
  if (code == COAXLE_OK) return;
  fprintf(stderr, "%s: error %" PRId32 ": %s\n", what, code, coaxle_last_error(handle));
  exit(1);
}

/* One end of the loopback. */
struct end {
  int socket;
  struct sockaddr_in address;
};

static struct end opened(void) {
  struct end end = {.socket = socket(AF_INET, SOCK_DGRAM, 0)};
  socklen_t length = sizeof end.address;
  end.address.sin_family = AF_INET;
  end.address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (end.socket < 0 || bind(end.socket, (struct sockaddr *)&end.address, length) != 0 ||
      getsockname(end.socket, (struct sockaddr *)&end.address, &length) != 0) {
    perror("socket");
    exit(1);
  }
  return end;
}

static void send_to(const struct end *from, const struct end *to, int64_t left, const char *key, const uint8_t *bytes,
                    size_t length) {
  static uint8_t datagram[COAXLE_MOST_BYTES + 256];
  const size_t head = sizeof left + strlen(key) + 1;
  memcpy(datagram, &left, sizeof left);
  strcpy((char *)datagram + sizeof left, key);
  memcpy(datagram + head, bytes, length);
  const ssize_t sent =
      sendto(from->socket, datagram, head + length, 0, (const struct sockaddr *)&to->address, sizeof to->address);
  if (sent < 0) {
    perror("sendto");
    exit(1);
  }
}

/* A datagram that has arrived. */
struct received {
  int64_t arrived;
  const char *key;
  const uint8_t *message;
  size_t length;
  uint8_t datagram[COAXLE_MOST_BYTES + 256];
};

/* Takes the next datagram, if there is one. */
static int receive(const struct end *end, struct received *received) {
  const ssize_t got = recv(end->socket, received->datagram, sizeof received->datagram - 1, MSG_DONTWAIT);
  if (got < (ssize_t)sizeof received->arrived) return 0;
  received->datagram[got] = 0;
  memcpy(&received->arrived, received->datagram, sizeof received->arrived);
  received->arrived += WAY_NS;
  received->key = (const char *)received->datagram + sizeof received->arrived;
  received->message = (const uint8_t *)received->key + strlen(received->key) + 1;
  received->length = (size_t)(received->datagram + got - received->message);
  return received->message <= received->datagram + got;
}

/* The master: frames, and responses to time requests, each with its clock. */
struct master {
  struct end end;
  coaxle_key *axes, *requests, *responses;
  uint32_t id;
  uint64_t count;
};

/* Far time at an instant of the own clock. */
static int64_t far_ns(int64_t now) { return (int64_t)((double)now * (1.0 - DRIFT)); }

static double position_at(double far_s) { return 500.0 * far_s + 20.0 * sin(3.0 * far_s); }

/* Own time at which the next frame leaves. */
static int64_t due(const struct master *master) {
  return (int64_t)((double)((int64_t)master->count * CYCLE_NS + LATE_NS) / (1.0 - DRIFT));
}

static void run_master(struct master *master, const struct end *to) {
  static struct received received;
  static uint8_t bytes[COAXLE_MOST_BYTES];
  size_t length;
  const double far_s = (double)master->count * 1e-3;
  const int64_t now = due(master);
  const coaxle_frame_header header = {
      .struct_size = sizeof header,
      .sender = master->id,
      .epoch = 7,
      .count = master->count,
      .cycle_time_ns = CYCLE_NS,
      .has_send_stamp = 1,
      .send_stamp_ns = LATE_NS,
  };
  const coaxle_axis axis = {
      .axis_id = 1,
      .state_word = 3, /* operational, homed */
      .set_position = position_at(far_s),
      .set_velocity = 500.0 + 60.0 * cos(3.0 * far_s),
      .set_acceleration = -180.0 * sin(3.0 * far_s),
  };
  check(master->axes,
        coaxle_frame_encode(master->axes, &header, &axis, 1, bytes, sizeof bytes, &length), "coaxle_frame_encode");
  send_to(&master->end, to, now, "coaxle/conveyor/axes", bytes, length);

  coaxle_time_request requests[16];
  size_t number = 0;
  while (number < 16 && receive(&master->end, &received)) {
    /* Its other messages are for those who follow it. */
    if (strcmp(received.key, "coaxle/conveyor/time-requests") != 0) continue;
    check(master->requests,
          coaxle_time_request_decode(master->requests, received.message, received.length, &requests[number]),
          "coaxle_time_request_decode");
    requests[number++].received_ns = far_ns(received.arrived);
  }
  if (number > 0) {
    check(master->responses,
          coaxle_time_responses_encode(master->responses, &header, requests, number, bytes, sizeof bytes, &length),
          "coaxle_time_responses_encode");
    send_to(&master->end, to, now, "coaxle/conveyor/time-responses", bytes, length);
  }
  master->count += 1;
}

int main(void) {
  struct master master = {.end = opened()};
  const struct end own = opened();
  check(NULL, coaxle_sender_id("conveyor", &master.id), "coaxle_sender_id");
  check(NULL, coaxle_key_new("coaxle/conveyor/axes", &master.axes), "coaxle_key_new");
  check(NULL, coaxle_key_new("coaxle/conveyor/time-requests", &master.requests), "coaxle_key_new");
  check(NULL, coaxle_key_new("coaxle/conveyor/time-responses", &master.responses), "coaxle_key_new");

  const coaxle_receiver_parameters parameters = {
      .struct_size = sizeof parameters, .drive = COAXLE_DRIVE_IDEAL, .start_ns = CYCLE_NS / 2, .epoch = 3};
  coaxle_receiver *station;
  check(NULL, coaxle_receiver_new(&parameters, "station.toml", CONFIG, &station), "coaxle_receiver_new");
  uint32_t conveyor, carriage;
  check(station, coaxle_receiver_find_axis(station, "conveyor.1", &conveyor), "coaxle_receiver_find_axis");
  check(station, coaxle_receiver_find_slave(station, "carriage", &carriage), "coaxle_receiver_find_slave");

  static struct received received;
  double worst = 0.0, worst_of_slave = 0.0;
  for (int64_t now = CYCLE_NS / 2; now < 20000 * CYCLE_NS; now += CYCLE_NS) {
    while (due(&master) <= now - WAY_NS) run_master(&master, &own);
    while (receive(&own, &received)) {
      const char *key;
      for (uint32_t n = 0; coaxle_receiver_subscription(station, n, &key) == COAXLE_OK; n++)
        if (strcmp(key, received.key) == 0)
          check(station, coaxle_receiver_message(station, n, received.arrived, received.message, received.length),
                "coaxle_receiver_message");
    }
    check(station, coaxle_receiver_cycle(station, now), "coaxle_receiver_cycle");

    static uint8_t bytes[COAXLE_MOST_BYTES];
    size_t length;
    for (;;) {
      const char *key;
      check(station, coaxle_receiver_send(station, now, &key, bytes, sizeof bytes, &length), "coaxle_receiver_send");
      if (length == 0) break;
      send_to(&own, &master.end, now, key, bytes, length);
    }
    coaxle_axis axis;
    coaxle_slave_state state = {.struct_size = sizeof state};
    if (now > 10000 * CYCLE_NS && coaxle_receiver_axis(station, conveyor, &axis) == COAXLE_OK &&
        coaxle_receiver_slave(station, carriage, &state) == COAXLE_OK) {
      const double truth = position_at((double)now * 1e-9 * (1.0 - DRIFT));
      worst = fmax(worst, fabs(axis.set_position - truth));
      worst_of_slave = fmax(worst_of_slave, fabs(state.position - 0.5 * axis.set_position));
    }
  }
  char health[32];
  check(station, coaxle_receiver_health(station, health, sizeof health), "coaxle_receiver_health");
  printf("health %s, far axis within %.6f mm of the truth, slave within %.2g mm of it\n", health, worst, worst_of_slave);
  coaxle_receiver_free(station);
  coaxle_key_free(master.axes);
  coaxle_key_free(master.requests);
  coaxle_key_free(master.responses);
  close(own.socket);
  close(master.end.socket);
  return strcmp(health, "ok") != 0 || !(worst > 0.0 && worst < 0.01) || worst_of_slave > 0.1;
}
