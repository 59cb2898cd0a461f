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

if [ $# -lt 2 ] || ! [[ $1 =~ ^[1-9][0-9]*$ ]]; then
    echo "usage: build.sh PARTS OUTPUT.nc [options of 'database build'] [-- options of 'merge']" >&2
    exit 2
fi
parts=$1 output=$(realpath -m -- "$2")
shift 2
build=() merge=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    build+=("$1")
    shift
done
[ $# -eq 0 ] || merge=("${@:2}")

here=$(dirname -- "$(realpath -- "$0")")
export SNOWBLUE=${SNOWBLUE:-snowblue}
version=$("$SNOWBLUE" --version)
folder=$output.parts
[ -d "$folder" ] || mkdir -- "$folder"

# Shards of another table would be taken for this one's, so what they were made with stands beside them. A file among the
# options (--axes) counts by what is in it.
recipe=$(
    printf '%s\n%s parts\n' "$version" "$parts"
    for option in ${build+"${build[@]}"}; do
        printf '%q\n' "$option"
        [ ! -f "${option#--axes=}" ] || cksum <"${option#--axes=}"
    done
)
shards=("$folder"/part-*.nc)
if [ -e "${shards[0]}" ] && [ "$(cat -- "$folder/recipe")" != "$recipe" ]; then
    echo "build.sh: $folder holds shards made with other options; remove it or name another output" >&2
    exit 1
fi
printf '%s\n' "$recipe" >"$folder/recipe"

# Logs are named relative to --chdir, since sbatch would read a '%' in the folder's name as a pattern. What a task wrote
# before it was requeued stays in its log.
common=(--parsable --export=ALL --chdir="$folder" --open-mode=append)
array=$(sbatch "${common[@]}" --requeue --array="1-$parts" --cpus-per-task="${CORES:-4}" --output=part-%a.log \
    "$here/part.sbatch" "$parts" "$folder" ${build+"${build[@]}"})
array=${array%%;*} # '12;cluster' where there are several clusters
# A part that failed for good takes the merge with it, which would wait for ever otherwise.
last=$(sbatch "${common[@]}" --requeue --dependency="afterok:$array" --kill-on-invalid-dep=yes --output=merge.log \
    "$here/merge.sbatch" "$parts" "$folder" "$output" ${merge+"${merge[@]}"})
last=${last%%;*}

hint() { printf '  %-32s %s\n' "$@"; }
echo "parts: job $array, $parts tasks; merge: job $last, after them; shards and logs: $folder"
hint "squeue --jobs $array,$last" "what waits and what runs"
hint "scontrol requeue ${array}_1" "start part 1 over"
hint "scancel $array $last" "stop; the shards that are there stay"
