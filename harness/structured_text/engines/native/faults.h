/*
 * What ends a scan instead of the process: a division by zero, an access to no memory of ours.
 */
#ifdef _WIN32 /* no such signals: a fault ends the process */

static const char *shim_guarded(const char *(*scan)(void)) { return scan(); }

#else

#include <setjmp.h>
#include <signal.h>
#include <stddef.h>

static sigjmp_buf shim_way_out;

static void shim_leave(int number) { siglongjmp(shim_way_out, number); }

/* Runs one scan; returns what went wrong, or NULL. */
static const char *shim_guarded(const char *(*scan)(void)) {
  static const int caught[] = {SIGFPE, SIGSEGV, SIGBUS};
  struct sigaction ours, theirs[3];
  const char *wrong;
  int number, k;
  sigemptyset(&ours.sa_mask);
  ours.sa_handler = shim_leave;
  ours.sa_flags = SA_NODEFER;
  for (k = 0; k < 3; k++) sigaction(caught[k], &ours, &theirs[k]);
  number = sigsetjmp(shim_way_out, 0);
  if (number == 0)
    wrong = scan();
  else if (number == SIGFPE)
    wrong = "the program divides by zero";
  else
    wrong = "the program has left its memory";
  for (k = 0; k < 3; k++) sigaction(caught[k], &theirs[k], NULL);
  return wrong;
}

#endif
