#!/usr/bin/env bash
# Proves that a study comes out the same on this machine and under Slurm: a controller and three nodes
# on this machine (Debian's slurm-wlm and munge), one of which is killed in the middle with all that runs
# on it. Needs root, since nodes start work as its user, and is left out of the tests for that.
#
#   laboratory/studies/slurm_check.sh BIN RECORDING FOLDER
#
# BIN: the folder of roomwise and roomwise-lab. RECORDING: of TUM's, with groundtruth.txt; twelve pieces of it
# are the homes. FOLDER: is made, and left with all logs.
set -euo pipefail

[ $# -eq 3 ] || { sed -n '2,10p' "$0"; exit 2; }
bin=$(realpath "$1")
recording=$(realpath "$2")
[ "$(id -u)" -eq 0 ] || { echo "$0: needs root"; exit 1; }
for program in slurmctld slurmd sbatch squeue munged; do
  command -v $program >/dev/null || { echo "$0: $program is not installed: apt install slurm-wlm munge"; exit 1; }
done
mkdir -p "$3"
work=$(realpath "$3")
pieces=12
frames=40
seeds='1, 2'

# ---- the homes: pieces of a walk ----

piece() { # NUMBER
  local to=$work/data/piece-$1 first=$((($1 - 1) * 60 + 1))
  mkdir -p "$to"
  ln -sfn "$recording/rgb" "$to/rgb"
  ln -sfn "$recording/depth" "$to/depth"
  cp "$recording/groundtruth.txt" "$to"
  for list in rgb depth; do
    grep -v '^#' "$recording/$list.txt" | sed -n "${first},$((first + frames - 1))p" >"$to/$list.txt"
  done
}
for i in $(seq $pieces); do piece "$i"; done

cat >"$work/pieces.toml" <<END
[study]
name = "pieces"
[factors]
home = [$(printf '"piece-%s", ' $(seq $pieces) | sed 's/, $//')]
seed = [$seeds]
[[steps]]
name = "map"
run = ["roomwise", "map", "{data}/{home}", "--home", "{map}/a.home", "--camera", "fr1", "--seed", "{seed}",
  "--trajectory", "{map}/path.txt"]
[[steps]]
name = "ate"
run = ["roomwise", "eval", "trajectory", "--truth", "{data}/{home}/groundtruth.txt", "--estimate", "{map}/path.txt"]
[values]
placed = "map/placed"
keyframes = "map/keyframes"
ate_m = "ate/ate_rmse_m"
[table]
rows = ["home"]
END

# ---- a cluster on this machine ----

export SLURM_CONF=$work/slurm.conf
host=$(hostname -s)
cat >"$SLURM_CONF" <<END
ClusterName=check
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=16817
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd-%n.log
SlurmdTimeout=10
KillWait=2
JobRequeue=1
ReturnToService=2
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=17001 CPUs=1
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=17002 CPUs=1
NodeName=n3 NodeHostname=$host NodeAddr=127.0.0.1 Port=17003 CPUs=1
PartitionName=all Nodes=n1,n2,n3 Default=YES MaxTime=INFINITE State=UP
END
mkdir -p "$work/state"
declare -A node=()
controller=
stop_all() {
  for process in "${node[@]}"; do kill -KILL "$process" 2>/dev/null || true; done # with all in it
  [ -n "$controller" ] && kill "$controller" 2>/dev/null || true
  [ -s "$work/munged.pid" ] && kill "$(cat "$work/munged.pid")" 2>/dev/null || true
}
trap stop_all EXIT
(umask 077 && head -c 128 /dev/urandom >"$work/munge.key")
munged --force --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munged.pid" \
  --log-file="$work/munged.log" --seed-file="$work/munged.seed"
slurmctld -D >"$work/slurmctld.out" 2>&1 &
controller=$!
start_node() { # in processes of its own, which all end with it, as with a machine whose power goes
  mkdir -p "$work/spool-$1"
  unshare --pid --fork --kill-child=KILL --mount-proc slurmd -D -N "$1" >"$work/slurmd-$1.out" 2>&1 &
  node[$1]=$!
}
for name in n1 n2 n3; do start_node $name; done
for _ in $(seq 60); do
  [ "$(sinfo --noheader --Node --format=%t 2>/dev/null | grep -c idle)" -eq 3 ] && break
  sleep 1
done
sinfo --Node || { tail -n 20 "$work"/*.log "$work"/*.out; exit 1; }

# ---- the same study, here and there ----

export ROOMWISE_MODELS=$work/no-networks # they would take most of the time
mkdir -p "$ROOMWISE_MODELS"
lab() { "$bin/roomwise-lab" "$@" 2>>"$work/lab.log"; }
clock() { date +%s.%N; }
since() { awk -v a="$1" -v b="$(clock)" 'BEGIN { printf "%.1f", b - a }'; }

begun=$(clock)
lab study "$work/pieces.toml" -o "$work/here" --data "$work/data" >"$work/here.txt" ||
  { tail -n 5 "$work/here.txt" "$work/lab.log"; exit 1; }
echo "on this machine, $(nproc) workers: $(since "$begun") s"

begun=$(clock)
lab study "$work/pieces.toml" -o "$work/slurm" --data "$work/data" --slurm --wait --look-every 1 >"$work/slurm.txt" &
study=$!
# Enough is done, enough is left, and the node is at something.
until [ "$(find "$work/slurm/results" -name '*.json' 2>/dev/null | wc -l)" -ge 6 ] &&
  squeue --noheader --nodelist=n2 --states=RUNNING --format=%i | grep -q .; do
  kill -0 $study 2>/dev/null || { echo "the study ended before a node was killed"; exit 1; }
  sleep 0.1
done
echo "node n2 is killed at $(squeue --noheader --nodelist=n2 --states=RUNNING --format='%i (%N)' | tr '\n' ' ')"
kill -KILL "${node[n2]}"
wait $study
echo "under Slurm, three nodes of one core each, one killed: $(since "$begun") s"

lab study-table "$work/here" >"$work/here.md"
lab study-table "$work/slurm" >"$work/slurm.md"
cmp "$work/here.md" "$work/slurm.md" && echo "the tables are the same to the digit"
cat "$work/slurm.md"
columns='task,factor_home,factor_seed,state,value_placed,value_keyframes,value_ate_m'
for way in here slurm; do sqlite3 -readonly "$work/$way/results.sqlite" "SELECT $columns FROM results ORDER BY task" >"$work/$way.rows"; done
cmp "$work/here.rows" "$work/slurm.rows" && echo "and so is every task: $(wc -l <"$work/slurm.rows") rows"
sqlite3 -readonly "$work/slurm/results.sqlite" \
  "SELECT 'tasks by node: ' || machine || ' ' || count(*) FROM results GROUP BY machine;
   SELECT 'begun more than once: ' || count(*) FROM results WHERE attempts > 1;
   SELECT 'seconds of a task, mean: ' || round(avg(seconds), 2) FROM results"
