#!/usr/bin/env bash
# Builds a table in parts on a Slurm cluster: an array job with one task per part, then a merge if all tasks succeed.
#
#     contrib/slurm/build.sh PARTS OUTPUT.nc [BUILD-OPTIONS] [-- MERGE-OPTIONS]
#     contrib/slurm/build.sh 5 snow.nc --preset fine -- --space log --components 3
#
# CORES (default 4) is the number of CPUs per task, SNOWBLUE (default snowblue) the program. sbatch's own variables,
# such as SBATCH_PARTITION, SBATCH_ACCOUNT and SBATCH_TIMELIMIT, apply to all jobs.
#
# Shards and logs go to OUTPUT.nc.parts, which all nodes must share. Running the same command again computes only
# missing shards; delete a shard, or the folder, to compute it again.
set -euo pipefail
source "$(dirname -- "$(realpath -- "$0")")/submit.bash"

if [ $# -lt 2 ] || ! [[ $1 =~ ^[1-9][0-9]*$ ]]; then
    echo "usage: contrib/slurm/build.sh PARTS OUTPUT.nc [BUILD-OPTIONS] [-- MERGE-OPTIONS]" >&2
    exit 2
fi
parts=$1 output=$(realpath -m -- "$2")
split_arguments "${@:3}"

folder=$output.parts
check_recipe "$(first_existing "$folder"/part-*-of-*)" "$parts" ${options[@]+"${options[@]}"}
array=$(submit_parts "$parts" "$here/part.sbatch" shard "$parts" "$folder" ${options[@]+"${options[@]}"})
last=$(submit_merge "$array" "$parts" "$folder" nc "$output" ${merge_options[@]+"${merge_options[@]}"})

echo "parts: job $array, $parts tasks; merge: job $last; shards and logs: $folder"
hint "squeue --jobs $array,$last" "show pending and running tasks"
hint "scontrol requeue ${array}_1" "restart part 1"
hint "scancel $array $last" "cancel; finished shards are kept"
