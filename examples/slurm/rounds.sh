#!/bin/sh
# A diagnosis whose calls of a program are made by job arrays of SLURM, round by round:
#
#   sh rounds.sh run.toml run 8
#
# run.toml is the configuration of a program (system.name = "command"), run a folder that all nodes see, 8 the number
# of jobs of a round. Ends with the exit status of `symplint check`, and with 2 where jobs are refused or make nothing in two
# rounds. A round that is stopped continues when this is started again.

config=$1
folder=$2
jobs=$3

# What jobs have brought so far: calls, and failures of calls.
progress() {
    wc -c <"$folder/journal"
    if [ -f "$folder/failed.json" ]; then cksum <"$folder/failed.json"; fi
}

symplint plan "$config" --out "$folder"
status=$?
idle=0
# 4: there is a round of calls.
while [ "$status" = 4 ]; do
    before=$(progress)
    # Ends with the exit status of the jobs; without a number, there are no jobs.
    job=$(sbatch --parsable --wait --array="1-$jobs" --job-name=symplint --output=/dev/null \
        --wrap="symplint advance '$folder' --part \$SLURM_ARRAY_TASK_ID/$jobs")
    if [ -z "$job" ]; then
        echo "rounds.sh: sbatch takes no jobs; mend that and start this again, which goes on" >&2
        exit 2
    fi
    # What failed, or never ran, is in the next round again.
    symplint collect "$folder"
    status=$?
    if [ "$(progress)" != "$before" ]; then idle=0; else idle=$((idle + 1)); fi
    if [ "$status" = 4 ] && [ "$idle" = 2 ]; then
        echo "rounds.sh: two rounds made no call; see why by \`symplint advance $folder --part 1/1\`" >&2
        exit 2
    fi
done
exit "$status"
