/* status.c - names and sentences, all from the one list in ylm_base.h. */
#include "ylm_base.h"

static const char *const names[] = {
#define X(name, class, text) #name,
    YLM_STATUS_LIST(X)
#undef X
};

static const char *const texts[] = {
#define X(name, class, text) text,
    YLM_STATUS_LIST(X)
#undef X
};

enum status_class { CALLER, WORLD };
static const unsigned char classes[] = {
#define X(name, class, text) class,
    YLM_STATUS_LIST(X)
#undef X
};

static bool known(ylm_status s) { return (int)s >= 0 && s < YLM_STATUS_COUNT; }

const char *ylm_status_name(ylm_status s) { return known(s) ? names[s] : "?"; }

const char *ylm_status_text(ylm_status s) { return known(s) ? texts[s] : "unknown status"; }

bool ylm_status_is_callers(ylm_status s) { return known(s) && classes[s] == CALLER; }

const char *ylm_quantity_name(ylm_quantity q) {
  static const char *const quantities[] = {
#define X(name) #name,
      YLM_QUANTITY_LIST(X)
#undef X
  };
  return (int)q >= 0 && q < YLM_QUANTITY_COUNT ? quantities[q] : "?";
}

ylm_status ylm_fail(ylm_error *e, ylm_status s, const char *format, ...) {
  if (e) {
    va_list args;
    va_start(args, format);
    e->status = s;
    vsnprintf(e->text, sizeof e->text, format, args);
    va_end(args);
  }
  return s;
}

ylm_status ylm_fail_plain(ylm_error *e, ylm_status s) {
  return ylm_fail(e, s, "%s", ylm_status_text(s));
}

ylm_status ylm_no_memory(ylm_error *e) { return ylm_fail_plain(e, YLM_ENOMEM); }

ylm_status ylm_no_memory_for(ylm_error *e, const char *name) {
  return ylm_fail(e, YLM_ENOMEM, "%s: %s", name, ylm_status_text(YLM_ENOMEM));
}
