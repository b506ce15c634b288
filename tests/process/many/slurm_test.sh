#!/bin/bash
# marco map --many --slurm on one node: munge, controller and node daemon of Debian's slurm-wlm, started here on loopback
# and ended by their ids. Without the package, or without root, the test says SKIPPED.
#   slurm_test.sh BIN-FOLDER SOURCE-FOLDER [LOGS]
set -u
bin=$1
root=$2
logs=${3:-100}
for program in munged slurmctld slurmd sbatch; do
  PATH=$PATH:/usr/sbin command -v $program >/dev/null || { echo "SKIPPED: $program is not installed (slurm-wlm)"; exit 0; }
done
[ "$(id -u)" = 0 ] || { echo 'SKIPPED: slurmd needs root'; exit 0; }
PATH=$PATH:/usr/sbin
if [ "${MARCO_SLURM:-}" != inside ]; then
  # A network and host name of its own.
  MARCO_SLURM=inside exec unshare -mnu "$0" "$@"
fi
ip link set lo up
# Slurm looks for an address beside loopback's, and then uses those of its configuration.
ip link add cable_a type veth peer name cable_b || { echo 'SKIPPED: this system has no virtual cables (veth)'; exit 0; }
ip address add 10.78.0.1/24 dev cable_a
ip link set cable_a up
ip link set cable_b up
hostname localhost
folder=$(mktemp -d)
started=()
finish() {
  [ ${#started[@]} = 0 ] || kill -TERM "${started[@]}" 2>/dev/null
  sleep 1
  [ ${#started[@]} = 0 ] || kill -KILL "${started[@]}" 2>/dev/null
  rm -rf "$folder"
}
trap finish EXIT
fail() {
  echo "FAILED: $*"
  tail -n 20 "$folder"/*.log "$folder"/out/jobs/slurm*.log 2>/dev/null
  exit 1
}

mkdir -p "$folder"/{state,spool,munge,logs}
chmod 755 "$folder" "$folder/munge"
head -c 1024 /dev/urandom >"$folder/munge/key"
chmod 400 "$folder/munge/key"
timeout 600 munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
  --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" >"$folder/munged.log" 2>&1 &
started+=($!)
cat >"$folder/slurm.conf" <<TEXT
ClusterName=marco
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/ctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldPort=6817
SlurmdPort=6818
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0,defer
NodeName=localhost NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=localhost Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
TEXT
export SLURM_CONF=$folder/slurm.conf
timeout 600 slurmctld -D -c >"$folder/slurmctld.log" 2>&1 &
started+=($!)
timeout 600 slurmd -D -N localhost >"$folder/slurmd.log" 2>&1 &
started+=($!)
for _ in $(seq 60); do
  [ "$(timeout 5 sinfo -h -o %T 2>/dev/null)" = idle ] && break
  sleep 0.5
done
[ "$(timeout 5 sinfo -h -o %T)" = idle ] || fail 'Slurm does not come up'

for i in $(seq "$logs"); do
  printf 'start_m = [2.0, 3.0]\nstart_heading_deg = 0\n[[steps]]\nto_m = [3.%02d, 2.4]\n' "$i" >"$folder/tour.toml"
  mkdir -p "$folder/in"
  "$bin/marco-simulate" --world "$root/config/worlds/lab.toml" --tour "$folder/tour.toml" --seed "$i" \
    --out "$folder/in/run_$i.lcm" >/dev/null || fail 'cannot simulate'
done
"$bin/marco-map-many" "$folder/in" --out "$folder/out" --jobs 2 --slurm || fail 'not submitted'
# Tasks and the programs below them are killed at random: Slurm calls them failed, and the same command does what is left.
RANDOM=5
kills=0
wanted=$((logs / 5 + 2))
victims() { pgrep -f "marco-map $folder/in|marco-map-many --task .*$folder"; }
for round in $(seq 10); do
  for _ in $(seq 1200); do
    [ -n "$(squeue -h)" ] || break
    sleep "$((RANDOM % 2)).$((RANDOM % 10))"
    mapfile -t running < <(victims)
    [ $kills -lt $wanted ] && [ ${#running[@]} -gt 0 ] || continue
    kill -KILL "${running[RANDOM % ${#running[@]}]}" 2>/dev/null && kills=$((kills + 1))
  done
  grep -q 'not done' "$folder/out/table.csv" || break
  echo "round $round: $(grep -c 'not done' "$folder/out/table.csv") recordings are left after $kills kills; again"
  "$bin/marco-map-many" --out "$folder/out" --jobs 2 --slurm || fail 'not submitted again'
done
[ $kills -gt 0 ] || fail 'nothing was killed'
rows=$(tail -n +2 "$folder/out/table.csv")
[ "$(echo "$rows" | wc -l)" = "$logs" ] || fail 'not every log has a row'
echo "$rows" | grep -q 'failed\|not done' && fail 'not every log was mapped'
again=$(awk -F, '{ if (is_done[$2]) print $2; if ($3 == "done") is_done[$2] = 1 }' "$folder/out/jobs/journal.csv")
[ -z "$again" ] || fail "begun again though they were done: $again"
[ "$(find "$folder/out" -name report.json | wc -l)" = "$logs" ] || fail 'not every log has its report'
[ "$(grep -o 'run_[0-9]*/map.png' "$folder/out/index.html" | sort -u | wc -l)" = "$logs" ] || fail 'not every log has its picture in the page'
echo "$logs recordings under Slurm, $kills kills: each done once, the table is complete"
