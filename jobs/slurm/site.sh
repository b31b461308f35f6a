# Settings of your cluster, the only file here to edit. docs/cluster.md explains them.
# A copy elsewhere will do as well: export HPCRUB_SITE=/path/of/the/copy

PARTITION=                   # empty: the default one
ACCOUNT=                     # empty: the default one
TIME=12:00:00                # time limit of a job; a study that takes longer goes on in a new one
STOP_BEFORE=120              # [s] before the limit the study is stopped and the job queued again
RANKS=16                     # MPI ranks of a job or of an array task, one on each core
MEMORY=1G                    # of a rank
TASKS_AT_ONCE=               # array tasks that may run at the same time; empty: any number
MOST_RESTARTS=50             # times that a job queues itself again
LOGS=logs                    # folder of the jobs' output
MORE_OPTIONS=()              # more for sbatch, such as (--qos=long --constraint=zen4)

LAUNCHER=mpirun              # or "srun --mpi=pmix"; `srun --mpi=list` shows what there is

prepare() {                  # what a shell needs before the program runs, on login nodes too
    :
    # module load gcc openmpi hdf5/1.14-mpi
    # export HDF5_DIR=$HDF5_ROOT        # for `make setup APT=no`
}
