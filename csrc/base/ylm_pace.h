/* ylm_pace.h - how often long work reports. */
#ifndef YLM_PACE_H
#define YLM_PACE_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
** ylm_progress_pace - the seconds between two reports that work aims at, which this thread begins from now on.
**
**   every  in  0: 0.1
**
** Work on a device reports at 0.1 whatever the pace. Thread-safe: each thread has its own.
*/
YLM_API void ylm_progress_pace(double every);

/*
** ylm_progress_still - whether no thread writes while work reports, which this thread begins from now on, so that a report
** may read what is done. The next ylm_progress_pace ends it. Thread-safe: each thread has its own.
*/
YLM_API void ylm_progress_still(bool still);

#ifdef __cplusplus
}
#endif
#endif
