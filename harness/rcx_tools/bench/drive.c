/*
 * Replays inputs to one side of cost.py, compares all outputs, and measures the scans.
 *
 * What stands before it gives side_begin(now), and side_scan(connected, start, in, out, now).
 * From stdin: the number of scans, then per scan connected, start, 48 bytes in, 48 bytes out.
 * Output: one line per repetition, nanoseconds per scan; status 1 where an output differs.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct { unsigned char connected, start, in[48], out[48]; } rcx_record;

static double rcx_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1e9 + now.tv_nsec;
}

int main(int count_of_arguments, char **arguments) {
  int scans, repetitions = count_of_arguments > 1 ? atoi(arguments[1]) : 1;
  if (fread(&scans, sizeof scans, 1, stdin) != 1) return 2;
  rcx_record *records = malloc(scans * sizeof *records);
  if (fread(records, sizeof *records, scans, stdin) != (size_t)scans) return 2;
  long long now = 0;
  for (int repetition = 0; repetition <= repetitions; repetition++) {
    unsigned char out[48] = { 0 };
    double started, total;
    side_begin(now);
    started = rcx_ns();
    for (int k = 0; k < scans; k++, now += 10000) {
      side_scan(records[k].connected, records[k].start, records[k].in, out, now);
      if (repetition == 0 && memcmp(out, records[k].out, 34)) {
        fprintf(stderr, "scan %d: other outputs than those recorded\n", k);
        return 1;
      }
    }
    total = rcx_ns() - started;
    if (repetition) printf("%.3f\n", total / scans);
  }
  return 0;
}
