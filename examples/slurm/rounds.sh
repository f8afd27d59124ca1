#!/bin/sh
# A diagnosis whose calls of a program are made by job arrays of SLURM, round by round:
#
#   sh rounds.sh run.toml run 8
#
# run.toml is the configuration of a program (system.name = "command"), run a folder that all nodes see, 8 the number
# of jobs of a round. Ends with the exit status of `symplint check`. A round that is stopped goes on when this is started again.

config=$1
folder=$2
jobs=$3

symplint plan "$config" --out "$folder"
status=$?
# 4: there is a round of calls.
while [ "$status" = 4 ]; do
    sbatch --wait --array="1-$jobs" --job-name=symplint --output=/dev/null \
        --wrap="symplint advance '$folder' --part \$SLURM_ARRAY_TASK_ID/$jobs"
    # What failed, or never ran, is in the next round again.
    symplint collect "$folder"
    status=$?
done
exit "$status"
