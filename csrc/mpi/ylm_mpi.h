/*
** ylm_mpi.h - a team of the processes that mpirun or srun has started.
**
** MPI starts, numbers and counts: which process takes which task, who waits for whom, whether all
** agree. Messages are two-sided. Process 0 hands out tasks, by a thread of its own where the
** library has MPI_THREAD_SERIALIZED, so that it may compute meanwhile.
*/
#ifndef YLM_MPI_H
#define YLM_MPI_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
** ylm_mpi_begin - the team of all processes; MPI starts with the first call.
**
**   team     out  lasts as long as the process; its size is 1 where no launcher of this MPI has
**                 started the process
**   threads  out  for each of them: processors of its affinity mask over the processes of its
**                 machine that share it
**
** Returns  YLM_OK; YLM_EPEER, YLM_ENOMEM
**
** MPI ends with the process. A process that ends with a status other than 0, or has gone on alone,
** ends the others too (MPI_Abort): when all have come to their ends, but within four seconds.
*/
YLM_API ylm_status ylm_mpi_begin(ylm_team **team, int *threads, ylm_error *e);

/* Does this process go on alone, since the others did not hear of its failure, or one has ended? */
YLM_API bool ylm_mpi_is_alone(void);

/* The library in a line, "Open MPI v4.1.4". */
YLM_API const char *ylm_mpi_version(void);

#ifdef __cplusplus
}
#endif

#endif
