# The help of ./marco; read by ./marco, whose name it uses.

usage() {
  cat <<'TEXT' | sed "s|\./marco|$name|g"
Marco: indoor maps and 3D models from a 2D laser, on LCM.

Try it:
  ./marco demo [--out DIR]             a simulated robot maps a lab in real time (5 minutes): drivers, procman, lcm-logger,
                                       replay, pictures, errors against the truth (--batch: simulated in 20 seconds)

A map from a recording:
  ./marco map INPUT... [--out DIR]     map your own log or 3D scans       (./marco map --help)
  ./marco map --many DIR --out DIR     map every recording in a folder, several at a time or under Slurm; a table of all
                                       (./marco map --many --help)
  ./marco check INPUT...               judge its map: good, doubtful or wrong, where and why; writes nothing
  ./marco calibrate LOG [--out DIR]    the laser's mount (extrinsics), scales of wheels and gyroscope, from a drive with turns;
                                       the pan-tilt's lever arms and zero angles, from sweeps of a room
  ./marco model SCAN... [--out DIR]    one 3D model from scans of any scanner: PCD, PLY, XYZ, PTS, PTX, uos

Results:
  ./marco page [MAP|LOG]               a page in the browser: live, a map folder or a recording (./marco page --help)
  ./marco render WHAT --out PNG        pictures of a map folder or a model (./marco render --help)
  ./marco export OUT --html [FILE]     a map folder as one HTML file for any browser, without network
  ./marco plan OUT                     a map folder's floor plan to scale: rooms, areas, doors (PDF, SVG, DXF, GeoJSON)
  ./marco plan OUT --against PLAN      the building's deviations from a DXF or SVG plan; --import: localize in that plan
  ./marco texture PLY PHOTOGRAPHS      texture a model with photographs    (./marco texture --help)
  ./marco evaluate TRAJ RELATIONS      error of a trajectory               (./marco evaluate --help)
  ./marco evaluate-model PLY WORLD     error of a model                    (./marco evaluate-model --help)
  ./marco python [SCRIPT]              python3 with `import marco`: recordings as numpy arrays, maps, matching, a live robot

A running robot:
  ./marco devices [PORT...]            list what is plugged in, with rates; --write DIR: files that start it
  ./marco first-drive [--out FILE]     check a robot before its first drive, step by step, and write a report
  ./marco run SCRIPT.procman [NAME]    start a robot's processes under the sheriff
  ./marco drive                        drive the running robot with keyboard or gamepad, from a second terminal
  ./marco stop [--release]             stop every base at once, and keep it stopped until --release
  ./marco go X Y                       drive the running robot to a point of the map [m], straight on
  ./marco head PAN TILT                point the running robot's pan-tilt [degrees]; 0 0: ahead and level
  ./marco program ORDER [NAME]         control the programs of ./marco run: list, start, stop, restart
  ./marco slam ORDER [NAME]            control the running SLAM: save, localize, extend, reset, set-pose, pause, resume
  ./marco bridge [ws://ROBOT:8765]     map with a robot that runs MBot, dimos, ROS 1 or ROS 2   (./marco bridge --help)
  ./marco relay --listen PORT          carry LCM to hosts that multicast does not reach: Wi-Fi, VPN, cloud (docs/two_hosts.md)

Recordings and messages:
  ./marco log COMMAND ...              info, cut, filter, merge, export, import, convert (LCM, ROS bags, MCAP), repair, play,
                                       recordings, keep
  ./marco replay LOG [--speed X]       play a log's input channels into the running processes
  ./marco spy [LOG]                    inspect channels: publishers, rates, jitter, losses   (./marco spy --help)

For developers of Marco:
  ./marco test [--long]                build with warnings as errors, run every test
                                       (--tsan: the rooms with threads; --valgrind [LOG]: a batch run under memcheck)
                                       (--peers: readers and writers against those of ROS and MCAP)
                                       (--asan: unit tests under address and undefined behaviour sanitizers)
                                       (--golden: compare the maps of all recordings with those kept; --mutants: do the
                                       short tests notice a wrong line?)
  ./marco lint [FILE...]               clang-format, clang-tidy, spelling and comments, lines by room (--format, --tidy,
                                       --docs, --lines: one of them; --since REV: only changes)
  ./marco bench                        speed of this machine (--accuracy: errors of the maps of all recordings)
  ./marco fuzz [--minutes N] [TARGET]  fuzz every decoder (clang; --ci: 20 s for three targets;
                                       --quick: fast decoders without AddressSanitizer, many more runs;
                                       --coverage: lines that the corpora reach)
  ./marco soak [--hours N]             a long simulated drive: memory and cost per scan
  ./marco soak --faults [NAME...]      inject faults while mapping live, one by one (--random MINUTES: combinations)
  ./marco soak --load                  scans per second that live SLAM can process
  ./marco soak --small                 an hour with a quarter of one core and 512 MB, as root
  ./marco package [OUT]                Debian packages of all programs, the library and the manual (--arch arm64: for a Pi)
  ./marco licenses                     list Marco's dependencies, with versions and licences

./marco COMMAND --help, or ./marco help COMMAND, explains a command; ./marco --version prints the version.
A command first installs the Debian packages and builds the programs that it needs, and reports both.
Exit codes: 0 success, 1 error, 2 usage error, 3 the map was judged wrong.
TEXT
}

command_names() { usage | sed -n "s|^  $name \([a-z-]*\).*|\1|p" | sort -u; }

# $1: a command that is no single program with a --help of its own.
help_of() {
  case $1 in
    demo) cat <<'TEXT'
./marco demo [--out DIR] [--live | --batch]
Maps a simulated tour of config/worlds/lab.toml, renders the result, and compares it with the truth.
  --out DIR  folder for the results (out/demo)
  --live     (default, 5 minutes) the robot in real time: config/sim.procman starts simulator, drivers, SLAM and
             lcm-logger, the tour follows SLAM's pose, lcm-logplayer plays the recording to a new SLAM
  --batch    (20 seconds) simulate as fast as possible, without processes
TEXT
      ;;
    lint) cat <<'TEXT'
./marco lint [--format | --tidy | --docs | --lines] [--since REV] [FILE...]
Checks the code with .clang-format and .clang-tidy, its wording and its size; without FILEs the whole tree.
  --format     only the layout (seconds)
  --tidy       only clang-tidy (an hour of one core for the whole tree)
  --docs       only spelling, unusual phrases, and doxygen's warnings (seconds; always the whole tree)
  --lines      only the lines of each room against the budget in tools/lines.txt (seconds; always the whole tree)
  --since REV  only files changed since this branch left REV
TEXT
      ;;
    python) cat <<'TEXT'
./marco python [SCRIPT | -c CODE | ...]
Runs python3 with the module `marco` on its path; examples/lesson.py is a tutorial, help(marco) in Python explains it.
  import marco
  recording = marco.read("my.bag")            # scans, odometry, ... as numpy arrays
  map = marco.map("my.bag")                   # map.grid, map.trajectory, map.verdict
  robot = marco.Robot()                       # robot.scan(), robot.pose(), robot.drive(0.2)
TEXT
      ;;
    run) cat <<'TEXT'
./marco run SCRIPT.procman [NAME] [OPTION...]
Starts a robot's processes under the sheriff, with a built-in deputy, and runs the script NAME of the file.
Marco's scripts config/*.procman work from any folder. Without a terminal there is no screen: NAME is required, and the processes run
until Ctrl-C or SIGTERM.
Results, recordings and ports are in out/run (MARCO_RUN changes this). Each run begins a new map; that of the previous run is
kept, and MARCO_RESUME=FILE resumes it.
Options go to the sheriff; marco-procman-sheriff --help lists them all. The most useful:
  -n, --no-gui                        no screen: run the script, print what happens
  --on-script-complete exit|observer  after the script: exit and stop its processes, or watch (the default)
  --output                            without a screen: print the commands' output
TEXT
      ;;
    replay) cat <<'TEXT'
./marco replay LOG [--speed X] [--foreign FILE]
Plays the input channels of a recording (lasers, odometry, IMU, pan-tilt, sonar, cameras; lasers and odometry of other
systems, too) into the running processes. Recorded results and orders to the robot are left out.
  --speed X       times real time (1)
  --foreign FILE  meaning of other systems' channels, see config/foreign.toml
TEXT
      ;;
    test) cat <<'TEXT'
./marco test [--long | --peers | --asan | --tsan | --valgrind [LOG] | --golden | --mutants]
Builds with warnings as errors and runs every test.
  --long            also the statistical tests that take minutes, then unit and process tests under the sanitizers
  --peers           readers, writers and the bridge against other people's programs (from apt and npm)
  --asan            unit tests under the address and undefined behaviour sanitizers
  --tsan            the rooms with threads under the thread sanitizer
  --valgrind [LOG]  a batch run under valgrind's memcheck (logs/sample.lcm)
Tests on real logs find them through MARCO_TEST_DATA; without it they are SKIPPED.
./marco test --golden [--write] [--jobs N] [NAME...]
Maps every recording below MARCO_TEST_DATA, the simulated tours and two live runs with a release build, and compares path, map,
verdict, set-up, loops, model and errors with tests/golden/figures.json. Exit code 1: a figure moved; the table says which.
  --write   keeps today's figures
  --jobs N  maps at a time (as many as there are processors)
  NAME      recordings whose path below MARCO_TEST_DATA begins so
./marco test --mutants [ROOM] [N] [SEED]
Changes a line of the sources, N times (60), and counts how often the short tests of its room notice. Works on a clone of the
last commit in build/mutants; after an interruption the same command continues. Exit code 1: fewer than 88 % were noticed.
  ROOM  a folder of tests/mutants/rooms.txt, such as slam/map (all)
  SEED  chooses the mutants: the same commit and seed give the same ones (1)
TEXT
      ;;
    bench) cat <<'TEXT'
./marco bench [OPTION...]
Measures the speed of this machine: each step's benchmark five times, then the whole job. Options go to Google Benchmark,
e.g. --benchmark_filter=REGEX.
./marco bench --accuracy [--only WORD] [--copies N] [--write]
Errors of the maps of every recording below MARCO_TEST_DATA and of simulated tours, as tables in Markdown (half an hour).
  --only WORD  recordings whose path contains WORD
  --copies N   copies of each, with 1 mm of range noise (10)
  --write      into docs/benchmarks.md
TEXT
      ;;
    fuzz) cat <<'TEXT'
./marco fuzz [--minutes N] [--seconds N] [--jobs N] [--longest BYTES] [--quick] [TARGET...]
Feeds hostile bytes to every decoder, or to the TARGETs. Crashing inputs are kept in build/fuzz/work, and the exit code is 1.
  --minutes N, --seconds N  for each target (1 minute)
  --jobs N                  targets at a time (2)
  --longest BYTES           of an input (4096); shorter ones run much faster
  --quick                   fast decoders without AddressSanitizer, many more runs
./marco fuzz --ci           20 s for each of three targets, others every day
./marco fuzz --coverage     lines of the decoders that the corpora reach
TEXT
      ;;
    soak) cat <<'TEXT'
./marco soak [--hours N] [--report-hours N] [--world FILE] [--tour FILE]
A long simulated drive at batch speed: memory and cost per scan.
  --hours N         simulated (12)
  --report-hours N  interval of the report lines (1)
./marco soak --faults [NAME...] [--times N] [--random MINUTES] [--seed N] [--keep]
Injects faults while mapping live, one by one; --random: combinations. --keep: keep the folders of all runs.
./marco soak --load [--speeds X...]
Scans per second that live SLAM can process.
./marco soak --small [--share X...] [--memory MB] [--seconds N] [--no-rate] [--keep]
The load of a small computer: base, RPLIDAR at 10 Hz, SLAM, recorder and one client of the page in a control group.
Needs root. With the first share nothing may be dropped.
  --share X...  of one core (0.25)
  --memory MB   (512)
  --seconds N   per run (3600)
  --no-rate     skip 7-zip's benchmark, which compares the core with a Raspberry Pi 4's if 7zz is installed
TEXT
      ;;
    package) cat <<'TEXT'
./marco package [OUT] [--arch amd64|arm64]
Writes Debian packages into OUT (out/packages): marco-robot, marco-robot-viewer, lcm-tools, python3-marco-robot,
libmarco-robot-dev and marco-robot-doc. DEBFULLNAME and DEBEMAIL name the maintainer.
  --arch arm64  cross build, e.g. for a Raspberry Pi, against an arm64 Debian unpacked into build/arm64_root
TEXT
      ;;
    licenses) cat <<'TEXT'
./marco licenses
Lists Marco's dependencies, with the versions on this machine and licences, checked against the packages' copyright files.
TEXT
      ;;
  esac | sed "s|\./marco|$name|g"
}

# Of a command whose program is not built yet.
help_from_page() {
  sed -n "/^## $command\$/,/^## /{/^## /d;s/^    //;p}" "$root/docs/options.md" | sed '1{/^$/d}'
}

# $1: a word, then names. The name with the fewest typing errors, at most one in three letters; else nothing.
# As closest_name in lcm_tools/process/suggest.hpp, which need not be built here.
closest_name() {
  local word=$1 other best="" i j cost most
  shift
  most=$((${#word} / 3 > 0 ? ${#word} / 3 : 1))
  for other; do
    local -A errors=()
    for ((i = 0; i <= ${#word}; ++i)); do
      for ((j = 0; j <= ${#other}; ++j)); do
        if ((i == 0 || j == 0)); then errors[$i,$j]=$((i + j)); continue; fi
        cost=$((errors[$((i - 1)),$((j - 1))] + 1))
        [ "${word:i-1:1}" = "${other:j-1:1}" ] && cost=${errors[$((i - 1)),$((j - 1))]}
        ((errors[$((i - 1)),$j] + 1 < cost)) && cost=$((errors[$((i - 1)),$j] + 1))
        ((errors[$i,$((j - 1))] + 1 < cost)) && cost=$((errors[$i,$((j - 1))] + 1))
        if ((i > 1 && j > 1)) && [ "${word:i-1:1}${word:i-2:1}" = "${other:j-2:1}${other:j-1:1}" ]; then
          ((errors[$((i - 2)),$((j - 2))] + 1 < cost)) && cost=$((errors[$((i - 2)),$((j - 2))] + 1))
        fi
        errors[$i,$j]=$cost
      done
    done
    cost=${errors[${#word},${#other}]}
    if ((cost <= most && cost < ${#other})); then most=$((cost - 1)) best=$other; fi
  done
  echo "$best"
}

# $1: what it is (command, option), $2: the word, then the names there are.
unknown() {
  local what=$1 word=$2 near
  shift 2
  [ ${#word} -gt 40 ] || near=$(closest_name "$word" "$@")
  echo "marco: unknown $what '$word'${near:+; did you mean '$near'?}" >&2
  echo "Try $name ${command:+$command }--help" >&2
  exit 2
}
