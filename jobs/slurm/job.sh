# Sourced by the job scripts: the site's settings, and a study that can be stopped and goes on.
# Slurm runs a copy of a job script, so it finds the repository by HPCRUB, which `submit` sets, or
# as the folder that the job was submitted from.

child='' limit='' cancelled='' trapped=''
pass_on() {  # tell the program that the time limit is near; launchers pass USR1 on to all ranks
    limit=near trapped=yes
    [ -z "$child" ] || kill -USR1 "$child" || :
}
# Slurm sends USR1 to this shell only, SIGTERM to the launcher and the ranks as well: twice would
# make mpirun kill the ranks, so this shell only waits for them.
trap pass_on USR1
trap 'cancelled=yes trapped=yes' TERM

HPCRUB=${HPCRUB:-$SLURM_SUBMIT_DIR}
PYTHON=$HPCRUB/.venv/bin/python
# shellcheck source=site.sh
source "${HPCRUB_SITE:-$HPCRUB/jobs/slurm/site.sh}"
prepare

export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1
# When a job is cancelled, mpirun kills its ranks after this many seconds, not after one: enough to
# finish the file (Open MPI 4, 5). Slurm itself waits for 30.
export OMPI_MCA_odls_base_sigkill_timeout=10 PRTE_MCA_odls_base_sigkill_timeout=10

# The words of the script: inputs, --, options of main.py, which stay in "$@".
inputs=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    inputs+=("$1")
    shift
done
[ $# -eq 0 ] || shift

one_rank() {  # the program without MPI
    "$PYTHON" "$HPCRUB/main.py" "$@"
}

launch() {  # the program on all ranks of the job; returns its exit code
    local code
    # In the background, as bash runs a trap only between two commands or while it waits.
    # shellcheck disable=SC2086  # the launcher is several words
    $LAUNCHER "$PYTHON" "$HPCRUB/main.py" "$@" </dev/null &
    child=$!
    [ -z "$limit" ] || pass_on
    while
        trapped=
        code=0
        wait "$child" || code=$?
        [ -n "$trapped" ]  # not the end of the program, but a trap ended the wait
    do :; done
    return "$code"
}
study() {  # run a study or go on with it; ends the job. Arguments: those of main.py
    local code=0
    if one_rank "$@" --status; then
        exit 0
    fi
    launch "$@" --resume || code=$?
    case $code in
        0 | 1 | 2) exit "$code" ;;  # done, failed, wrong input
    esac
    [ -z "$limit" ] || [ -n "$cancelled" ] || queue_again  # Slurm would revive a cancelled job
    exit "$code"
}

queue_again() {
    if [ "${SLURM_RESTART_COUNT:-0}" -ge "$MOST_RESTARTS" ]; then
        echo "job: stopped before the time limit, and queued again $MOST_RESTARTS times already" >&2
        return
    fi
    echo "job: stopped before the time limit; queued again, to go on"
    scontrol requeue "$SLURM_JOB_ID"
}
