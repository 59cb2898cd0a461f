#!/usr/bin/env bash
# Builds a table in parts on a Slurm cluster: an array of tasks, one for each part, and a merge once all of them succeeded.
#
#     contrib/slurm/build.sh PARTS OUTPUT.nc [options of 'database build'] [-- options of 'merge']
#     contrib/slurm/build.sh 5 snow.nc --preset fine -- --space log --components 3
#
# CORES (4) is how many each task asks for, SNOWBLUE (snowblue) which program to run. sbatch's own variables, such as
# SBATCH_PARTITION, SBATCH_ACCOUNT and SBATCH_TIMELIMIT, hold for all jobs.
#
# Shards and logs go to OUTPUT.nc.parts, which every node must see. The same command run again computes only the shards
# that are not there; remove a shard, or the folder, to have it computed anew.
set -euo pipefail
source "$(dirname -- "$(realpath -- "$0")")/submit.bash"

if [ $# -lt 2 ] || ! [[ $1 =~ ^[1-9][0-9]*$ ]]; then
    echo "usage: build.sh PARTS OUTPUT.nc [options of 'database build'] [-- options of 'merge']" >&2
    exit 2
fi
parts=$1 output=$(realpath -m -- "$2")
take "${@:3}"

folder=$output.parts
keep_recipe "$(first_there "$folder"/part-*-of-*)" "$parts" ${taken[@]+"${taken[@]}"}
array=$(submit_parts "$parts" "$here/part.sbatch" shard "$parts" "$folder" ${taken[@]+"${taken[@]}"})
last=$(submit_merge "$array" "$parts" "$folder" nc "$output" ${rest[@]+"${rest[@]}"})

echo "parts: job $array, $parts tasks; merge: job $last, after them; shards and logs: $folder"
hint "squeue --jobs $array,$last" "what waits and what runs"
hint "scontrol requeue ${array}_1" "start part 1 over"
hint "scancel $array $last" "stop; the shards that are there stay"
