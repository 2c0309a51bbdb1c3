#!/bin/sh
# One-node Slurm that runs the job arrays of `pmcip farm`, one task of them killed and queued again; then compares.
#
#   sh tests/support/slurm.sh path/to/pmcip        # as root; needs Debian's slurm-wlm and munge
#
# A word on what is missing, and success, where it cannot run.
set -eu
pmcip=$(realpath "$1")
for program in munged slurmctld slurmd sbatch scontrol squeue; do
    command -v $program > /dev/null || { echo "skipped: $program is not installed"; exit 0; }
done
[ "$(id -u)" = 0 ] || { echo "skipped: the daemons want root"; exit 0; }
work=$(mktemp -d)
PATH=$(dirname "$pmcip"):$PATH
export PATH SLURM_CONF="$work/slurm.conf"

stop() {
    kill "$ctld" "$node" 2> /dev/null || true
    munged --stop --socket="$work/munge.socket" 2> /dev/null || kill "$(cat "$work/munged.pid")" || true
    rm -rf "$work"
}
trap stop EXIT

host=$(hostname -s)
head -c 1024 /dev/urandom > "$work/munge.key"
chmod 400 "$work/munge.key"
chmod 755 "$work"
cat > "$work/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
SlurmctldPort=26817
SlurmdPort=26818
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobRequeue=1
ReturnToService=2
SchedulerParameters=requeue_delay=1
NodeName=$host CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
mkdir "$work/state" "$work/spool" "$work/farm" "$work/alone"
munged --force --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munged.pid" \
    --log-file="$work/munged.log" --seed-file="$work/munge.seed"
slurmctld -D > "$work/out.log" 2>&1 & ctld=$!
slurmd -D >> "$work/out.log" 2>&1 & node=$!
n=0
until sinfo -h -o %T 2> /dev/null | grep -q idle; do
    n=$((n + 1))
    [ $n -lt 60 ] || { cat "$work"/*.log; echo "Slurm does not start"; exit 1; }
    sleep 1
done

# Waits until the queue is empty.
drain() {
    while [ -n "$(squeue -h)" ]; do sleep 1; done
}

scene=$(realpath "$(dirname "$0")/../../scenes")
frames="render $scene/cornell-anim.toml --frames 1..8 --size 96x96 --spp 256 -o walk.exr"
frame="render $scene/cornell.toml --size 96x96 --spp 64 -o box.exr"
cd "$work/farm"
pmcip farm slurm --chunk 2 --checkpoint 0 -- $frames > frames.sh
job=$(sbatch --parsable frames.sh)
sleep 3
# The first task is killed in the middle and queued again.
echo "killed and queued again: $(squeue -h -t R -o %i | head -1)"
scontrol requeue "$(squeue -h -t R -o %i | head -1)"
sleep 2
scontrol release "$job" 2> /dev/null || true
drain
pmcip farm slurm --seeds 8 -- $frame > seeds.sh
sbatch --parsable seeds.sh
drain
sed -n 's/^#   pmcip /pmcip /p' seeds.sh | sh
cd "$work/alone"
pmcip $frames --quiet
for number in 1 2 3 4 5 6 7 8; do
    cmp "walk.000$number.exr" "$work/farm/walk.000$number.exr"
done
pmcip reference "$scene/cornell.toml" --size 96x96 --spp 4096 --quiet -o truth.exr
pmcip $frame --quiet
pmcip error box.exr truth.exr
pmcip error "$work/farm/box.exr" truth.exr
echo "chunks are those of one run, bit by bit; eight seeds are merged"
