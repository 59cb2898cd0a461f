# A private Slurm cluster of one node on loopback. Sourced by scripts/test-slurm and scripts/test-slurm-render.
# Needs root and Debian, and installs packages without removing them; meant for a container. Sets $snowblue, the program
# (SNOWBLUE, or built here), and $top, a temporary folder that is removed on exit together with the cluster.

say() { printf '\n== %s\n' "$*"; }
fail() { printf 'FAILED: %s\n' "$*" >&2 && exit 1; }

[ "$(id -u)" -eq 0 ] || fail "slurmd and apt-get need root"

if ! type slurmctld slurmd sbatch munged >/dev/null 2>&1; then
    say "packages"
    apt-get update -qq
    # RUNLEVEL=1 prevents the packages from starting their daemons.
    RUNLEVEL=1 DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends \
        slurmctld slurmd slurm-client munge >/dev/null
fi
if [ -z "${SNOWBLUE:-}" ]; then
    say "snowblue"
    cargo build --release --locked -p snowblue-cli
    SNOWBLUE=${CARGO_TARGET_DIR:-$PWD/target}/release/snowblue
fi
snowblue=$(realpath "$SNOWBLUE")

top=$(mktemp -d)
chmod 755 "$top"
daemons=()
clean() {
    # Jobs first: their slurmstepd processes outlive slurmd by design.
    [ ! -e "$top/up" ] || { scancel --user="$(id -un)" && sleep 2; } 2>/dev/null || true
    for daemon in "${daemons[@]}"; do kill "$daemon" 2>/dev/null || true; done
    for daemon in "${daemons[@]}"; do timeout 10 tail -f /dev/null --pid="$daemon" || true; done
    rm -rf "$top"
}
trap clean EXIT
trap 'exit 1' INT TERM

show_logs() { tail -n 15 "$top"/*.log >&2 || true; }

# Removes this machine's folders and name from the output.
anonymised() {
    sed "s|$top/[^/]*/||g; s|$(printf %q "$top")/[^/]*/||g; s|slurmstepd-$host|slurmstepd|; s| ON $host | |"
}

# Waits until a command succeeds. Fails the test after the given number of seconds.
await() {
    local seconds=$1 what=$2 end=$((SECONDS + $1))
    shift 2
    until "$@" >/dev/null 2>&1; do
        [ "$SECONDS" -lt "$end" ] || { show_logs && fail "$what: timeout after $seconds s"; }
        sleep 0.1
    done
}

say "a cluster of one node"
host=$(hostname -s)
port=$((20000 + $$ % 10000))
mkdir -m 755 "$top"/{munge,state,spool}
dd if=/dev/urandom of="$top/munge/key" bs=1 count=1024 status=none
chmod 400 "$top/munge/key"
munged --foreground --force --key-file="$top/munge/key" --socket="$top/munge/socket" --pid-file="$top/munge/pid" \
    --seed-file="$top/munge/seed" --log-file="$top/munge.log" >/dev/null 2>&1 &
daemons+=($!)
# The node claims 2 CPUs, so two tasks run at a time on any machine. A requeued task waits until its old credential has
# expired.
cat >"$top/slurm.conf" <<END
ClusterName=loopback
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$top/munge/socket,cred_expire=5
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
StateSaveLocation=$top/state
SlurmdSpoolDir=$top/spool
SlurmctldPidFile=$top/slurmctld.pid
SlurmdPidFile=$top/slurmd.pid
SlurmctldLogFile=$top/slurmctld.log
SlurmdLogFile=$top/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
SlurmdTimeout=10
KillWait=2
MinJobAge=3600
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
END
export SLURM_CONF=$top/slurm.conf
start_slurmd() {
    slurmd -D >/dev/null 2>&1 &
    slurmd=$!
    disown # prevents bash from reporting its end
    daemons+=("$slurmd")
}
await 20 "munged" test -S "$top/munge/socket"
slurmctld -D >/dev/null 2>&1 &
daemons+=($!)
start_slurmd
await 60 "an idle node" eval '[ "$(sinfo --noheader --format=%t)" = idle ]'
touch "$top/up"
sinfo --version
sinfo --format='%P %D nodes, %c cores, %t'

mkdir "$top/a folder with spaces"
contrib=$PWD/contrib/slurm
cd "$top/a folder with spaces"

# Creates the program 'worker', which records its process ID, runs the given commands and then executes snowblue.
make_worker() {
    cat >worker <<END
#!/usr/bin/env bash
attempt=\$((\${SLURM_RESTART_COUNT:-0} + 1))
[ -z "\${SLURM_ARRAY_TASK_ID:-}" ] || echo \$\$ >"$top/worker-\$SLURM_ARRAY_TASK_ID-\$attempt"
ulimit -c 0
$1
exec "$snowblue" "\$@"
END
    chmod +x worker
}
worker() { cat "$top/worker-$1-1"; }
ended() { ! kill -0 "$(worker "$1")"; }

# Reads the job IDs from the output of build.sh or render.sh.
read_jobs() {
    array=$(sed -n 's/^parts: job \([0-9]*\).*/\1/p' "$top/output")
    merge=$(sed -n 's/.*merge: job \([0-9]*\).*/\1/p' "$top/output")
}
queue() { squeue --jobs="$array${merge:+,$merge}" --array --sort=i --format='%10i %15j %10T %r'; }
job_field() { scontrol show job "$1" | sed -n "s/.*$2=\([^ ]*\).*/\1/p"; }
state() { job_field "$1" JobState | head -n 1; }
is() { [ "$(state "$1")" = "$2" ]; }
over() { is "$1" COMPLETED || is "$1" FAILED || is "$1" CANCELLED; }
