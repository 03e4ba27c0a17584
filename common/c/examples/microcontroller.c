/* An axis of a microcontroller: each cycle a datagram to a gateway, and the axis as a receiver has corrected it back.
 * Needs no library; the last third is of a PC, and other on a microcontroller. docs/PLC.md, "By UDP".
 *
 *   cc -std=c11 microcontroller.c -o microcontroller && ./microcontroller 5067 5066 30    (with coaxle example plc-udp)
 */
#include <stdint.h>
#include <string.h>

enum { CYCLE_US = 2000, RECORD_SIZE = 2 + 128 }; /* the cycle index, and an image of NCTOPLC_AXLESTRUCT */

static void put(uint8_t *at, uint64_t value, int bytes) {
  for (int i = 0; i < bytes; i++) at[i] = (uint8_t)(value >> 8 * i);
}

static void put_double(uint8_t *at, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  put(at, bits, 8);
}

static double taken_double(const uint8_t *at) {
  uint64_t bits = 0;
  double value;
  for (int i = 0; i < 8; i++) bits |= (uint64_t)at[i] << 8 * i;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* Makes the datagram of a cycle. All other fields of the image may stay 0. */
static void record_of(uint8_t record[RECORD_SIZE], uint32_t cycle, double position, double velocity, double acceleration) {
  uint8_t *image = record + 2;
  memset(record, 0, RECORD_SIZE);
  put(record, cycle & 0xFFFF, 2);
  put(image, 3, 4); /* nStateDWord: operational, homed */
  put_double(image + 80, position);
  put_double(image + 88, velocity);
  put_double(image + 96, acceleration);
}

/* The PC's part: sockets on 127.0.0.1, a clock, and a belt at 500 mm/s. */
#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <time.h>

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

int main(int arguments, char **argument) {
  if (arguments != 4) return fprintf(stderr, "usage: microcontroller LISTEN-PORT GATEWAY-PORT SECONDS\n"), 2;
  struct sockaddr_in own = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)}, gateway = own;
  own.sin_port = htons((uint16_t)atoi(argument[1]));
  gateway.sin_port = htons((uint16_t)atoi(argument[2]));
  int socket_of = socket(AF_INET, SOCK_DGRAM, 0);
  if (bind(socket_of, (struct sockaddr *)&own, sizeof own) != 0) return perror("LISTEN-PORT"), 1;
  const uint32_t cycles = (uint32_t)(atof(argument[3]) * 1e6 / CYCLE_US);
  double *errors = calloc(cycles, 2 * sizeof *errors), start = now();
  uint32_t came = 0;
  for (uint32_t cycle = 0; cycle < cycles && errors != NULL; cycle++) {
    uint8_t record[RECORD_SIZE], corrected[RECORD_SIZE];
    double at = 1e-6 * CYCLE_US * cycle, wait = start + at - now();
    if (wait > 0) nanosleep(&(struct timespec){.tv_nsec = (long)(1e9 * wait)}, NULL);
    record_of(record, cycle, 500.0 * at, 500.0, 0.0);
    sendto(socket_of, record, sizeof record, 0, (struct sockaddr *)&gateway, sizeof gateway);
    while (came < cycles && recv(socket_of, corrected, sizeof corrected, MSG_DONTWAIT) == RECORD_SIZE) {
      errors[2 * came] = taken_double(corrected + 2 + 80) - 500.0 * (now() - start);
      errors[2 * came++ + 1] = taken_double(corrected + 2 + 88);
    }
  }
  printf("%u\n", came); /* then the error (mm) and the velocity (mm/s) of the newest */
  for (uint32_t i = came > 500 ? came - 500 : 0; i < came; i++) printf("%.3f %.3f\n", errors[2 * i], errors[2 * i + 1]);
  free(errors);
  return 0;
}
