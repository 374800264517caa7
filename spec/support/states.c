/*
** states.c - runs a script in several Lua states at once, one in each thread, for specs.
**
**   states SCRIPT THREADS ROUNDS FOLDER
**
** The script gets FOLDER, a name of the state and the number of the round, and returns a string. The first thread runs it
** alone; all others begin together, make ROUNDS states one after the other, and must get the string that the first got.
** Prints the string, and how many states there were. A status of 1: a string differed, or a script failed.
*/
#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS = 16 };

#ifdef __SANITIZE_THREAD__
/* The C library keeps the stacks of threads that have ended, by locks that the checker does not see. */
const char *__tsan_default_suppressions(void);
const char *__tsan_default_suppressions(void) { return "race:_dl_deallocate_tls\n"; }
#endif

typedef struct worker {
  char **argv;
  int number;
  int rounds;
  char *said; /* the script's string, or its error */
  const char *wanted;
  int failed;
  pthread_barrier_t *begin;
} worker;

/* One state from its beginning to its end; the script's string or error. */
static char *in_a_state(char **argv, int number, int round, int *failed) {
  char name[32], none[] = "no string";
  snprintf(name, sizeof name, "state%d", number);
  lua_State *L = luaL_newstate();
  luaL_openlibs(L);
  *failed = luaL_loadfile(L, argv[1]);
  if (!*failed) {
    lua_pushstring(L, argv[4]);
    lua_pushstring(L, name);
    lua_pushinteger(L, round);
    *failed = lua_pcall(L, 3, 1, 0);
  }
  const char *text = lua_tostring(L, -1);
  if (!text) *failed = 1;
  char *copy = strdup(text ? text : none);
  lua_close(L);
  return copy;
}

static void *work(void *user) {
  worker *w = user;
  pthread_barrier_wait(w->begin);
  for (int round = 1; round <= w->rounds && !w->failed; round++) {
    free(w->said);
    w->said = in_a_state(w->argv, w->number, round, &w->failed);
    if (strcmp(w->said, w->wanted) != 0) w->failed = 1;
  }
  return NULL;
}

int main(int argc, char **argv) {
  if (argc != 5) return 2;
  int threads = atoi(argv[2]), rounds = atoi(argv[3]), failed = 0;
  if (threads < 1 || threads > THREADS) return 2;
  char *wanted = in_a_state(argv, 0, 0, &failed);
  printf("%s\n", wanted);
  if (failed) return 1;
  pthread_barrier_t begin;
  pthread_barrier_init(&begin, NULL, (unsigned)threads);
  worker team[THREADS];
  pthread_t thread[THREADS];
  for (int i = 0; i < threads; i++) {
    team[i] = (worker){
        .argv = argv, .number = i + 1, .rounds = rounds, .wanted = wanted, .begin = &begin};
    if (pthread_create(&thread[i], NULL, work, &team[i]) != 0) return 2;
  }
  for (int i = 0; i < threads; i++) {
    pthread_join(thread[i], NULL);
    if (team[i].failed) printf("state %d: %s\n", i + 1, team[i].said);
    failed |= team[i].failed;
    free(team[i].said);
  }
  printf("%d states\n", threads * rounds);
  free(wanted);
  return failed;
}
