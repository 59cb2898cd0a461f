# Submits jobs to Slurm. Sourced by build.sh and render.sh, which set $folder, the folder of parts and logs. All nodes
# must share it.

here=$(dirname -- "$(realpath -- "$0")")
export SNOWBLUE=${SNOWBLUE:-snowblue}

fail() {
    printf '%s: %s\n' "$(basename -- "$0")" "$2" >&2
    exit "$1"
}

# Splits arguments at the first '--' into $options and $merge_options.
split_arguments() {
    options=()
    while [ $# -gt 0 ] && [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    merge_options=("${@:2}")
}

# Records the version and the arguments in $folder/recipe, and fails if the existing file $1 was made with others. Files
# among the arguments are compared by content.
check_recipe() {
    local existing=$1 version recipe argument
    version=$("$SNOWBLUE" --version)
    recipe=$(
        printf '%s\n' "$version"
        for argument in "${@:2}"; do
            printf '%q\n' "$argument"
            [ ! -f "${argument#--*=}" ] || cksum <"${argument#--*=}"
        done
    )
    [ -d "$folder" ] || mkdir -- "$folder"
    if [ -n "$existing" ] && [ "$(cat -- "$folder/recipe" 2>/dev/null)" != "$recipe" ]; then
        fail 1 "$existing was made with other options; delete it or choose another output"
    fi
    printf '%s\n' "$recipe" >"$folder/recipe"
}

# The first file that exists.
first_existing() {
    local file
    for file in "$@"; do
        [ ! -e "$file" ] || { echo "$file" && break; }
    done
}

# Log names are relative to --chdir, since sbatch expands '%' in folder names. A requeued task appends to its log.
submit() {
    local job
    job=$(sbatch --parsable --export=ALL --chdir="$folder" --open-mode=append --requeue "$@")
    echo "${job%%;*}" # '12;cluster' on multi-cluster systems
}

submit_parts() {
    submit --array="1-$1" --cpus-per-task="${CORES:-4}" --output=part-%a.log "${@:2}"
}

# A failed part cancels the merge, which would otherwise stay pending forever.
submit_merge() {
    submit --dependency="afterok:$1" --kill-on-invalid-dep=yes --output=merge.log "$here/merge.sbatch" "${@:2}"
}

hint() { printf '  %-32s %s\n' "$@"; }
