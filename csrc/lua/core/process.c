/* process.c - what the command-line tool asks of its process: interrupts, standard output. */
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "../binding.h"

/* A signal's handler knows nothing but the process. */
static volatile sig_atomic_t interrupted;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct sigaction before; /* the interpreter's handler, which raises "interrupted!" */

static void on_interrupt(int signal_number) {
  interrupted = 1;
  if (before.sa_handler == SIG_DFL) {
    signal(signal_number, SIG_DFL);
    raise(signal_number);
  } else if (before.sa_handler != SIG_IGN) {
    before.sa_handler(signal_number);
  }
}

/* process_watch() - from here on process_interrupted tells of SIGINT, which the interpreter still
   handles. Standard streams that are closed become ones that take nothing: a file that is opened
   later must not get their number. */
static int process_watch(lua_State *L) {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
    if (fcntl(fd, F_GETFD) < 0 && errno == EBADF)
      (void)!open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  struct sigaction own = {.sa_handler = on_interrupt}, now;
  sigemptyset(&own.sa_mask);
  own.sa_flags = SA_RESTART;
  pthread_mutex_lock(&lock);
  bool watches = sigaction(SIGINT, NULL, &now) == 0 && now.sa_handler != on_interrupt &&
                 !(now.sa_flags & SA_SIGINFO); /* that is of another kind than signal() sets */
  if (watches) {
    before = now;
    sigaction(SIGINT, &own, NULL);
  }
  pthread_mutex_unlock(&lock);
  if (!watches) return 0;
  lua_pushboolean(L, 1);
  return 1;
}

/* process_interrupted() -> has there been a SIGINT? */
static int process_interrupted(lua_State *L) {
  lua_pushboolean(L, interrupted);
  return 1;
}

/* process_flush() -> true; nil, message, code where standard output did not take all that was
   written, now or earlier */
static int process_flush(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = YLM_OK;
  bool failed = ferror(stdout);
  errno = 0;
  if (fflush(stdout) != 0 || failed)
    s = ylm_fail(&e, YLM_EIO, "standard output cannot be written: %s",
                 errno ? strerror(errno) : "the device may be full");
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"process_watch", process_watch},
                                     {"process_interrupted", process_interrupted},
                                     {"process_flush", process_flush},
                                     {NULL, NULL}};

void ylmL_open_process(lua_State *L) { luaL_setfuncs(L, functions, 0); }
