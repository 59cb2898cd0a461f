#!/usr/bin/env bash
# Renders on a Slurm cluster: an array job with one task per part of an image, then a merge if all tasks succeed; or one
# task per scene, such as the frames of a film.
#
#     contrib/slurm/render.sh samples PARTS OUTPUT SCENE.toml --spp N [RENDER-OPTIONS] [-- MERGE-OPTIONS]
#     contrib/slurm/render.sh tiles PARTS OUTPUT SCENE.toml --width W --height H [RENDER-OPTIONS] [-- MERGE-OPTIONS]
#     contrib/slurm/render.sh frames 'FOLDER/{}.exr' SCENE.toml... [-- RENDER-OPTIONS] [-- MERGE-OPTIONS]
#
# Images are .exr, or .png with the exposure of the scene or of --exposure. In names of frames, {} stands for the name
# of the scene without folder and extension. The image is bitwise identical to that of a single run.
#
# CORES (default 4) is the number of CPUs per task, SNOWBLUE (default snowblue) the program. sbatch's own variables,
# such as SBATCH_PARTITION, SBATCH_ACCOUNT and SBATCH_TIMELIMIT, apply to all jobs. Near its time limit a task saves its
# samples and resumes in a new attempt.
#
# Parts and logs go to OUTPUT.parts (FOLDER/frames.exr.parts), which all nodes must share. Running the same command
# again renders only what is missing.
set -euo pipefail
source "$(dirname -- "$(realpath -- "$0")")/submit.bash"

usage() {
    sed -n 's/^#     contrib/usage: contrib/p' "$0" >&2
    exit 2
}

# The value of an option in $options, which must be a positive number.
count_of() {
    local value='' k
    for ((k = 0; k < ${#options[@]}; k++)); do
        case ${options[k]} in
        "$1") value=${options[k + 1]:-} ;;
        "$1"=*) value=${options[k]#*=} ;;
        esac
    done
    [[ $value =~ ^[1-9][0-9]*$ ]] || fail 2 "'$split' needs $1 with a number from 1"
    echo "$value"
}

[ $# -ge 3 ] || usage
split=$1
shift
case $split in
samples | tiles)
    [ $# -ge 3 ] && [[ $1 =~ ^[1-9][0-9]*$ ]] || usage
    parts=$1 output=$(realpath -m -- "$2") scene=$3
    [ -f "$scene" ] || fail 2 "scene $scene does not exist"
    split_arguments "${@:4}"
    part_options=(${options[@]+"${options[@]}"})
    if [ "$split" = samples ]; then
        total=$(count_of --spp)
        extent=("$total")
        # Each part gets its own range of samples instead.
        for ((k = 0; k < ${#options[@]}; k++)); do
            case ${options[k]} in
            --spp) unset "part_options[$k]" "part_options[$((k += 1))]" ;;
            --spp=*) unset "part_options[$k]" ;;
            esac
        done
    else
        width=$(count_of --width)
        total=$(count_of --height)
        extent=("$width" "$total")
    fi
    [ "$parts" -le "$total" ] || fail 2 "$parts parts are more than $total rows or samples"
    folder=$output.parts
    check_recipe "$(first_existing "$folder"/part-*-of-*)" "$split" "$parts" "$scene" ${options[@]+"${options[@]}"}
    work=("$split" "$parts" "$folder" "${extent[@]}" "$scene" ${part_options[@]+"${part_options[@]}"})
    ;;
frames)
    output=$(realpath -m -- "$1")
    [[ ${output##*/} == *{}* ]] || fail 2 "'$1' must contain {} in its file name, for the name of the scene"
    folder=${output%\{\}*}frames${output##*\{\}}.parts
    split_arguments "${@:2}"
    scenes=(${options[@]+"${options[@]}"}) images=() parts=${#options[@]}
    [ "$parts" -gt 0 ] || usage
    for scene in "${scenes[@]}"; do
        [ -f "$scene" ] || fail 2 "scene $scene does not exist"
        frame=${scene##*/}
        images+=("${output%\{\}*}${frame%.*}${output##*\{\}}")
    done
    duplicate=$(printf '%s\n' "${images[@]}" | sort | uniq -d | head -n 1)
    [ -z "$duplicate" ] || fail 2 "two scenes have the same output $duplicate"
    # The options of 'render' follow the scenes, and those of 'merge' follow another '--'.
    frame_options=(${merge_options[@]+"${merge_options[@]}"})
    check_recipe "$(first_existing "${images[@]}")" ${frame_options[@]+"${frame_options[@]}"}
    work=(frames "$parts" "$folder" "$output" "${scenes[@]}" ${frame_options[@]+"${frame_options[@]}"})
    ;;
*) usage ;;
esac

# Slurm signals each task a minute before its time limit, which is enough to save its samples.
array=$(submit_parts "$parts" --signal=B:USR1@60 "$here/part.sbatch" "${work[@]}")
jobs=$array
merge=
if [ "$split" = samples ] || [ "$split" = tiles ]; then
    last=$(submit_merge "$array" "$parts" "$folder" exr "$output" ${merge_options[@]+"${merge_options[@]}"})
    jobs=$array,$last merge="; merge: job $last"
fi

echo "parts: job $array, $parts tasks$merge; parts and logs: $folder"
hint "squeue --jobs $jobs" "show pending and running tasks"
hint "scontrol requeue ${array}_1" "restart part 1"
hint "scancel ${jobs/,/ }" "cancel; finished parts are kept"
