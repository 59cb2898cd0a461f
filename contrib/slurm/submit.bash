# How build.sh and render.sh hand their work to Slurm; sourced by them. They set $folder, which every node must see: parts
# and logs lie there.

here=$(dirname -- "$(realpath -- "$0")")
export SNOWBLUE=${SNOWBLUE:-snowblue}

refuse() {
    printf '%s: %s\n' "$(basename -- "$0")" "$2" >&2
    exit "$1"
}

# Arguments up to '--' into $taken, those behind it into $rest.
take() {
    taken=()
    while [ $# -gt 0 ] && [ "$1" != -- ]; do
        taken+=("$1")
        shift
    done
    rest=("${@:2}")
}

# What other work has made would be taken for this one's, so how it was made stands in $folder. A file among the arguments
# counts by what is in it.
keep_recipe() {
    local made=$1 version recipe argument
    version=$("$SNOWBLUE" --version)
    recipe=$(
        printf '%s\n' "$version"
        for argument in "${@:2}"; do
            printf '%q\n' "$argument"
            [ ! -f "${argument#--*=}" ] || cksum <"${argument#--*=}"
        done
    )
    [ -d "$folder" ] || mkdir -- "$folder"
    if [ -n "$made" ] && [ "$(cat -- "$folder/recipe" 2>/dev/null)" != "$recipe" ]; then
        refuse 1 "$made was made with other options; remove what is there or name another output"
    fi
    printf '%s\n' "$recipe" >"$folder/recipe"
}

# The first of some files that is there.
first_there() {
    local file
    for file in "$@"; do
        [ ! -e "$file" ] || { echo "$file" && break; }
    done
}

# Logs are named relative to --chdir, since sbatch would read a '%' in the folder's name as a pattern. What a task wrote
# before it was requeued stays in its log.
submit() {
    local job
    job=$(sbatch --parsable --export=ALL --chdir="$folder" --open-mode=append --requeue "$@")
    echo "${job%%;*}" # '12;cluster' where there are several clusters
}

submit_parts() {
    submit --array="1-$1" --cpus-per-task="${CORES:-4}" --output=part-%a.log "${@:2}"
}

# A part that failed for good takes the merge with it, which would wait for ever otherwise.
submit_merge() {
    submit --dependency="afterok:$1" --kill-on-invalid-dep=yes --output=merge.log "$here/merge.sbatch" "${@:2}"
}

hint() { printf '  %-32s %s\n' "$@"; }
