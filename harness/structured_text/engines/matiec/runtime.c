/*
 * The harness's side of a program that iec2c translated.
 *
 * It gives the program its clock, runs one base tick per call and holds the located variables.
 * What follows this text is written for each program: the storage of its located variables,
 * where its data lie (shim_regions), and how blocks and structures are laid out (shim_layout).
 */
#include "faults.h"

#include "iec_std_lib.h"
#include "accessor.h"
#include "POUS.h"

void config_init__(void);
void config_run__(unsigned long tick);
extern unsigned long greatest_tick_count__;

TIME __CURRENT_TIME;
BOOL __DEBUG = 0;

/* Number of the next tick; wraps where every task starts anew, as runtimes of matiec do. */
unsigned long long shim_tick;

void shim_start(void) { config_init__(); }

static const char *shim_run(void) {
  config_run__((unsigned long)shim_tick);
  return NULL;
}

/* Runs one base tick; returns what went wrong, or NULL. */
const char *shim_scan(long long now_us) {
  const char *wrong;
  __CURRENT_TIME.tv_sec = (long)(now_us / 1000000);
  __CURRENT_TIME.tv_nsec = (long)(now_us % 1000000) * 1000;
  wrong = shim_guarded(shim_run);
  shim_tick++;
  if (greatest_tick_count__) shim_tick %= greatest_tick_count__;
  return wrong;
}

