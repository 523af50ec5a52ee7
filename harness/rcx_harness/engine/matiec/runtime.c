/*
 * The harness's side of a program that iec2c translated.
 *
 * It gives the program its clock, runs one base tick per call and holds the located variables.
 * What follows this text is written for each program: the storage of its located variables,
 * where its data lie (rcx_regions), and how blocks and structures are laid out (rcx_layout).
 */
#include <setjmp.h>
#include <signal.h>
#include <stddef.h>

#include "iec_std_lib.h"
#include "accessor.h"
#include "POUS.h"

typedef struct {
  void *address;
  size_t size;
} rcx_region;

void config_init__(void);
void config_run__(unsigned long tick);
extern unsigned long greatest_tick_count__;

TIME __CURRENT_TIME;
BOOL __DEBUG = 0;

/* Number of the next tick; wraps where every task starts anew, as runtimes of matiec do. */
unsigned long rcx_tick;

/* A division of integers by zero ends the scan instead of the process. */
static sigjmp_buf rcx_way_out;

static void rcx_leave(int number) {
  (void)number;
  siglongjmp(rcx_way_out, 1);
}

/* Runs one base tick; returns 1 where the program divided by zero, else 0. */
int rcx_scan(long long now_us) {
  struct sigaction ours = {0}, theirs;
  int failed;
  ours.sa_handler = rcx_leave;
  ours.sa_flags = SA_NODEFER;
  __CURRENT_TIME.tv_sec = (long)(now_us / 1000000);
  __CURRENT_TIME.tv_nsec = (long)(now_us % 1000000) * 1000;
  sigaction(SIGFPE, &ours, &theirs);
  failed = sigsetjmp(rcx_way_out, 0);
  if (!failed) config_run__(rcx_tick);
  sigaction(SIGFPE, &theirs, NULL);
  rcx_tick++;
  if (greatest_tick_count__) rcx_tick %= greatest_tick_count__;
  return failed;
}

