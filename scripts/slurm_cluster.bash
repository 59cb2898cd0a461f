# A private Slurm cluster of one node on loopback, for scripts/test-slurm and scripts/test-slurm-render, which source this.
# Needs root and Debian, installs packages and leaves them; meant for a container. Sets $snowblue, the program (SNOWBLUE, or
# built here), and $top, a folder that goes away at the end together with the cluster.

say() { printf '\n== %s\n' "$*"; }
fail() { printf 'FAILED: %s\n' "$*" >&2 && exit 1; }

[ "$(id -u)" -eq 0 ] || fail "slurmd and apt-get need root"

if ! type slurmctld slurmd sbatch munged >/dev/null 2>&1; then
    say "packages"
    apt-get update -qq
    # RUNLEVEL keeps the packages from starting daemons of their own.
    RUNLEVEL=1 DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends \
        slurmctld slurmd slurm-client munge >/dev/null
fi
if [ -z "${SNOWBLUE:-}" ]; then
    say "snowblue"
    cargo build --release --locked -p snowblue-cli
    SNOWBLUE=$PWD/target/release/snowblue
fi
snowblue=$(realpath "$SNOWBLUE")

top=$(mktemp -d)
chmod 755 "$top"
daemons=()
clean() {
    # Jobs first: their shepherds outlive slurmd on purpose.
    [ ! -e "$top/up" ] || { scancel --user="$(id -un)" && sleep 2; } 2>/dev/null || true
    for daemon in "${daemons[@]}"; do kill "$daemon" 2>/dev/null || true; done
    for daemon in "${daemons[@]}"; do timeout 10 tail -f /dev/null --pid="$daemon" || true; done
    rm -rf "$top"
}
trap clean EXIT
trap 'exit 1' INT TERM

show_logs() { tail -n 15 "$top"/*.log >&2 || true; }

# Without this machine's folders and name.
shown() { sed "s|$top/[^/]*/||g; s|$(printf %q "$top")/[^/]*/||g; s|slurmstepd-$host|slurmstepd|; s| ON $host | |"; }

# A condition comes true within so many seconds, or the test fails.
await() {
    local seconds=$1 what=$2 end=$((SECONDS + $1))
    shift 2
    until "$@" >/dev/null 2>&1; do
        [ "$SECONDS" -lt "$end" ] || { show_logs && fail "$what: not within $seconds s"; }
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
# Two tasks run at a time, whatever the machine. A requeued task waits until its old credential has expired.
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
    disown # or bash would tell of its death
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

# A program, 'worker', that leaves its process number and does what else it is told before it becomes snowblue.
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
ends() { ! kill -0 "$(worker "$1")"; }

# The jobs that build.sh and render.sh told of.
submitted() {
    array=$(sed -n 's/^parts: job \([0-9]*\).*/\1/p' "$top/told")
    merge=$(sed -n 's/.*merge: job \([0-9]*\).*/\1/p' "$top/told")
}
queue() { squeue --jobs="$array${merge:+,$merge}" --array --sort=i --format='%10i %15j %10T %r'; }
told_of() { scontrol show job "$1" | sed -n "s/.*$2=\([^ ]*\).*/\1/p"; }
state() { told_of "$1" JobState | head -n 1; }
is() { [ "$(state "$1")" = "$2" ]; }
over() { is "$1" COMPLETED || is "$1" FAILED || is "$1" CANCELLED; }
