#!/usr/bin/env bash
# Renders on a Slurm cluster: an array of tasks, one for each part of a picture, and a merge once all of them succeeded; or one
# for each picture of an animation.
#
#     contrib/slurm/render.sh samples PARTS OUTPUT SCENE.toml --spp N [options of 'render'] [-- options of 'merge']
#     contrib/slurm/render.sh tiles PARTS OUTPUT SCENE.toml --width W --height H [options of 'render'] [-- options of 'merge']
#     contrib/slurm/render.sh frames 'FOLDER/{}.exr' SCENE.toml... [-- options of 'render'] [-- options of 'merge']
#
# Pictures are .exr, or .png, as bright as the scene or --exposure says. In names of frames {} is that of the scene, without
# folder and ending. Each way gives the picture of one go, bit by bit.
#
# CORES (4) is how many each task asks for, SNOWBLUE (snowblue) which program to run. sbatch's own variables, such as
# SBATCH_PARTITION, SBATCH_ACCOUNT and SBATCH_TIMELIMIT, hold for all jobs. Near its time limit a task keeps what it has
# and goes on from there in a new attempt.
#
# Parts and logs go to OUTPUT.parts (FOLDER/frames.exr.parts), which every node must see. The same command run again renders only
# what is not there.
set -euo pipefail
source "$(dirname -- "$(realpath -- "$0")")/submit.bash"

usage() {
    sed -n 's/^#     contrib\/slurm\//usage: /p' "$0" >&2
    exit 2
}

# The value of an option in $options, which must be a number from 1 on.
count_of() {
    local value='' k
    for ((k = 0; k < ${#options[@]}; k++)); do
        case ${options[k]} in
        "$1") value=${options[k + 1]:-} ;;
        "$1"=*) value=${options[k]#*=} ;;
        esac
    done
    [[ $value =~ ^[1-9][0-9]*$ ]] || refuse 2 "'$split' needs $1 and a number from 1 on, to know what to cut"
    echo "$value"
}

[ $# -ge 3 ] || usage
split=$1
shift
case $split in
samples | tiles)
    [ $# -ge 3 ] && [[ $1 =~ ^[1-9][0-9]*$ ]] || usage
    parts=$1 output=$(realpath -m -- "$2") scene=$3
    [ -f "$scene" ] || refuse 2 "there is no scene $scene"
    take "${@:4}"
    options=(${taken[@]+"${taken[@]}"})
    if [ "$split" = samples ]; then
        whole=$(count_of --spp)
        cut=("$whole")
        # Each part is told of its own samples instead.
        for ((k = 0; k < ${#taken[@]}; k++)); do
            case ${taken[k]} in
            --spp) unset "options[$k]" "options[$((k += 1))]" ;;
            --spp=*) unset "options[$k]" ;;
            esac
        done
    else
        width=$(count_of --width)
        whole=$(count_of --height)
        cut=("$width" "$whole")
    fi
    [ "$parts" -le "$whole" ] || refuse 2 "$whole rows or samples do not make $parts parts"
    folder=$output.parts
    keep_recipe "$(first_there "$folder"/part-*-of-*)" "$split" "$parts" "$scene" ${taken[@]+"${taken[@]}"}
    work=("$split" "$parts" "$folder" "${cut[@]}" "$scene" ${options[@]+"${options[@]}"})
    ;;
frames)
    output=$(realpath -m -- "$1")
    [[ ${output##*/} == *{}* ]] || refuse 2 "'$1' must have {} in its last part, which stands for the frame"
    take "${@:2}"
    scenes=(${taken[@]+"${taken[@]}"}) pictures=() parts=${#taken[@]}
    [ "$parts" -gt 0 ] || usage
    for scene in "${scenes[@]}"; do
        [ -f "$scene" ] || refuse 2 "there is no scene $scene"
        frame=${scene##*/}
        pictures+=("${output%\{\}*}${frame%.*}${output##*\{\}}")
    done
    twice=$(printf '%s\n' "${pictures[@]}" | sort | uniq -d | head -n 1)
    [ -z "$twice" ] || refuse 2 "two scenes would make $twice"
    folder=${output%\{\}*}frames${output##*\{\}}.parts
    options=(${rest[@]+"${rest[@]}"})
    keep_recipe "$(first_there "${pictures[@]}")" ${options[@]+"${options[@]}"}
    work=(frames "$parts" "$folder" "$output" "${scenes[@]}" ${options[@]+"${options[@]}"})
    ;;
*) usage ;;
esac

# A minute before the time limit a task is told so, enough to write what it has.
array=$(submit_parts "$parts" --signal=B:USR1@60 "$here/part.sbatch" "${work[@]}")
jobs=$array
merge=
if [ "$split" != frames ]; then
    last=$(submit_merge "$array" "$parts" "$folder" exr "$output" ${rest[@]+"${rest[@]}"})
    jobs=$array,$last merge="; merge: job $last, after them"
fi

echo "parts: job $array, $parts tasks$merge; parts and logs: $folder"
hint "squeue --jobs $jobs" "what waits and what runs"
hint "scontrol requeue ${array}_1" "start part 1 over"
hint "scancel ${jobs/,/ }" "stop; what is there stays"
