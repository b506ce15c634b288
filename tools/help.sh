# What ./marco says about itself; read by ./marco, whose name it uses.

usage() {
  cat <<'TEXT' | sed "s|\./marco|$name|g"
Marco: indoor maps and 3D models from a 2D laser, on LCM.

Try it:
  ./marco demo [--out DIR]             a simulated robot maps a lab in real time (5 minutes): drivers, procman, lcm-logger,
                                       replay, pictures, errors against the truth (--batch: simulated in 20 seconds)

A map from a recording:
  ./marco map INPUT... [--out DIR]     map your own log or 3D scans       (./marco map --help)
  ./marco map --many DIR --out DIR     map every recording in a folder, some at a time or under Slurm; a table of all
                                       (./marco map --many --help)
  ./marco check INPUT...               is its map good, doubtful or wrong, where and why; writes nothing
  ./marco calibrate LOG [--out DIR]    where the laser sits, how wheels and gyroscope count, from a drive with turns;
                                       the pan-tilt's lever arms and zero angles, from sweeps of a room
  ./marco model SCAN... [--out DIR]    one 3D model from scans of any scanner: PCD, PLY, XYZ, PTS, PTX, uos

What came of it:
  ./marco page [MAP|LOG]               a page in the browser: what runs, a map folder or a recording (./marco page --help)
  ./marco render WHAT --out PNG        pictures of a map folder or a model (./marco render --help)
  ./marco export OUT --html [FILE]     a map folder as one HTML file: opens in any browser, without network
  ./marco plan OUT                     a map folder's floor plan to scale: rooms, areas, doors (PDF, SVG, DXF, GeoJSON)
  ./marco plan OUT --against PLAN      where the building is not as a DXF or SVG plan has it; --import: localize in that plan
  ./marco texture PLY PHOTOGRAPHS      a model painted with photographs    (./marco texture --help)
  ./marco evaluate TRAJ RELATIONS      error of a trajectory               (./marco evaluate --help)
  ./marco evaluate-model PLY WORLD     error of a model                    (./marco evaluate-model --help)
  ./marco python [SCRIPT]              python3 with `import marco`: recordings as numpy arrays, maps, matching, a live robot

A robot that runs:
  ./marco devices [PORT...]            what is plugged in, what it is, at which rate; --write DIR: files that start it
  ./marco first-drive [--out FILE]     a robot that never drove: wheels, stop, bumper, laser, odometry, step by step; a report
  ./marco run SCRIPT.procman [NAME]    start a robot's processes under the sheriff
  ./marco drive                        the robot that runs, by keys or gamepad, from a second terminal
  ./marco stop [--release]             stops every base at once, and keeps it stopped until --release
  ./marco go X Y                       drives the robot that runs to a point of the map [m], straight on
  ./marco head PAN TILT                points the pan-tilt of the robot that runs [degrees]; 0 0: ahead and level
  ./marco program ORDER [NAME]         the programs that ./marco run started: list, start, stop, restart
  ./marco slam ORDER [NAME]            the SLAM that runs: save, localize, extend, reset, set-pose, pause, resume
  ./marco bridge [ws://ROBOT:8765]     maps with a robot of MBot, dimos, ROS 1 or ROS 2   (./marco bridge --help)
  ./marco relay --listen PORT          LCM to hosts that multicast does not reach: Wi-Fi, VPN, cloud (docs/two_hosts.md)

Recordings and messages:
  ./marco log COMMAND ...              info, cut, filter, merge, export, import, convert (LCM, ROS bags, MCAP), repair, play,
                                       recordings, keep
  ./marco replay LOG [--speed X]       a log's input channels into the processes that run
  ./marco spy [LOG]                    who says what, and who loses it   (./marco spy --help)

For those who develop Marco:
  ./marco test [--long]                build with warnings as errors, run every test
                                       (--tsan: the rooms with threads; --valgrind [LOG]: a batch run under memcheck)
                                       (--peers: what we read and write against ROS' and MCAP's own)
                                       (--asan: unit tests under address and undefined behaviour sanitizers)
                                       (--golden: have the maps of all recordings moved; --mutants: do the short tests
                                       notice a wrong line)
  ./marco lint [FILE...]               clang-format, clang-tidy, spelling and comments, lines by room (--format, --tidy,
                                       --docs, --lines: one of them; --since REV: the change)
  ./marco bench                        speed figures of this machine (--accuracy: errors of the maps of all recordings)
  ./marco fuzz [--minutes N] [TARGET]  hostile bytes into every decoder (clang; --ci: 20 s for three targets;
                                       --quick: fast decoders without AddressSanitizer, many times as often;
                                       --coverage: which of their lines the corpora reach)
  ./marco soak [--hours N]             a long simulated drive: memory and cost per scan
  ./marco soak --faults [NAME...]      what fails while mapping live, each in turn (--random MINUTES: combinations)
  ./marco soak --load                  how many scans a second live SLAM takes
  ./marco soak --small                 an hour with a quarter of one core and 512 MB, as root
  ./marco package [OUT]                Debian packages of all programs, the library and the manual (--arch arm64: of a Pi)
  ./marco licenses                     what Marco depends on, its versions and licences

./marco COMMAND --help, or ./marco help COMMAND, says more about a command; ./marco --version which Marco this is.
A command first installs the Debian packages it needs, builds the programs it needs, and says both.
Exit codes: 0 done, 1 refused or failed with a word, 2 a command line that makes no sense, 3 a map that is wrong.
TEXT
}

command_names() { usage | sed -n "s|^  $name \([a-z-]*\).*|\1|p" | sort -u; }

# $1: a command that is no single program with a --help of its own.
help_of() {
  case $1 in
    demo) cat <<'TEXT'
./marco demo [--out DIR] [--live | --batch]
A tour of config/worlds/lab.toml, mapped, rendered, and checked against the truth.
  --out DIR  folder for the results (out/demo)
  --live     (default, 5 minutes) the robot in real time: config/sim.procman starts simulator, drivers, SLAM and
             lcm-logger, the tour is driven by SLAM's pose, lcm-logplayer plays the recording to a new SLAM
  --batch    (20 seconds) the tour is simulated as fast as the machine can, without processes
TEXT
      ;;
    lint) cat <<'TEXT'
./marco lint [--format | --tidy | --docs | --lines] [--since REV] [FILE...]
Whether the code is laid out by .clang-format, what .clang-tidy says of it, how it reads, and whether it has grown; the whole
tree without FILEs.
  --format     only the layout (seconds)
  --tidy       only clang-tidy (an hour of one core for the whole tree)
  --docs       only spelling, phrases that nobody in the field uses, and doxygen's warnings (seconds; always the whole tree)
  --lines      only the lines of each room beside the budget of tools/lines.txt (seconds; always the whole tree)
  --since REV  only files that differ from where this branch left REV
TEXT
      ;;
    python) cat <<'TEXT'
./marco python [SCRIPT | -c CODE | ...]
python3 with the module `marco` on its path; examples/lesson.py is a lesson, help(marco) in Python says more.
  import marco
  recording = marco.read("my.bag")            # scans, odometry, ... as numpy arrays
  map = marco.map("my.bag")                   # map.grid, map.trajectory, map.verdict
  robot = marco.Robot()                       # robot.scan(), robot.pose(), robot.drive(0.2)
TEXT
      ;;
    run) cat <<'TEXT'
./marco run SCRIPT.procman [NAME] [OPTION...]
Starts a robot's processes under the sheriff, with a deputy of its own, and runs the script NAME of the file.
Scripts of ours are config/*.procman, from any folder. Without a terminal there is no screen: NAME is needed, and what it starts keeps running
until Ctrl-C or SIGTERM.
Results, recordings and ports are in out/run (MARCO_RUN says otherwise). Each run begins a new map; that of the run before is
kept, and MARCO_RESUME=FILE resumes it.
Options go to the sheriff; marco-procman-sheriff --help lists them all. The most useful:
  -n, --no-gui                        no screen: run the script, print what happens
  --on-script-complete exit|observer  when the script is done: exit, stopping what it started, or watch (the default)
  --output                            without a screen: print the commands' output
TEXT
      ;;
    replay) cat <<'TEXT'
./marco replay LOG [--speed X] [--foreign FILE]
Plays the input channels of a recording (lasers, odometry, IMU, pan-tilt, sonar, cameras; lasers and odometry of other
systems, too) into the processes that run. What they made of it the last time, and orders to the robot, are left out.
  --speed X       times real time (1)
  --foreign FILE  the meaning of other systems' channels, see config/foreign.toml
TEXT
      ;;
    test) cat <<'TEXT'
./marco test [--long | --peers | --asan | --tsan | --valgrind [LOG] | --golden | --mutants]
Builds with warnings as errors and runs every test.
  --long            also the statistics that take minutes, then unit and process tests under the sanitizers
  --peers           what we read and write, and the bridge, against other people's programs (from apt and npm)
  --asan            unit tests under the address and undefined behaviour sanitizers
  --tsan            the rooms with threads under the thread sanitizer
  --valgrind [LOG]  a batch run under valgrind's memcheck (logs/sample.lcm)
Tests on real logs find them through MARCO_TEST_DATA and say SKIPPED without it.
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
  SEED  which mutants: the same commit and seed give the same ones (1)
TEXT
      ;;
    bench) cat <<'TEXT'
./marco bench [OPTION...]
Speed figures of this machine: each step's benchmark five times, then the whole job. Options go to Google Benchmark,
e.g. --benchmark_filter=REGEX.
./marco bench --accuracy [--only WORD] [--copies N] [--write]
Errors of the maps of every recording below MARCO_TEST_DATA and of simulated tours, as tables in Markdown (half an hour).
  --only WORD  recordings whose path holds it
  --copies N   of each, with 1 mm of range noise (10)
  --write      into docs/benchmarks.md
TEXT
      ;;
    fuzz) cat <<'TEXT'
./marco fuzz [--minutes N] [--seconds N] [--jobs N] [--longest BYTES] [--quick] [TARGET...]
Hostile bytes into every decoder, or into the TARGETs. What crashes one is kept in build/fuzz/work, and the exit code is 1.
  --minutes N, --seconds N  for each target (1 minute)
  --jobs N                  targets at a time (2)
  --longest BYTES           of an input (4096); short ones run many times as often
  --quick                   fast decoders without AddressSanitizer, many times as often
./marco fuzz --ci           20 s for each of three targets, other ones every day
./marco fuzz --coverage     which lines of the decoders the corpora reach
TEXT
      ;;
    soak) cat <<'TEXT'
./marco soak [--hours N] [--report-hours N] [--world FILE] [--tour FILE]
A long simulated drive at batch speed: memory and cost per scan.
  --hours N         simulated (12)
  --report-hours N  a line each (1)
./marco soak --faults [NAME...] [--times N] [--random MINUTES] [--seed N] [--keep]
What fails while mapping live, each in turn; --random: combinations. --keep: the folders of all runs.
./marco soak --load [--speeds X...]
How many scans a second live SLAM takes.
./marco soak --small [--share X...] [--memory MB] [--seconds N] [--no-rate] [--keep]
What a small computer has to do: base, RPLIDAR at 10 Hz, SLAM, recorder and one client of the page in a control group.
As root. Nothing may be dropped with the first share.
  --share X...  of one core (0.25)
  --memory MB   (512)
  --seconds N   a run (3600)
  --no-rate     without 7-zip's benchmark, which compares the core with a Raspberry Pi 4's where 7zz is installed
TEXT
      ;;
    package) cat <<'TEXT'
./marco package [OUT] [--arch amd64|arm64]
Writes Debian packages into OUT (out/packages): marco-robot, marco-robot-viewer, lcm-tools, python3-marco-robot,
libmarco-robot-dev and marco-robot-doc. DEBFULLNAME and DEBEMAIL name who made them.
  --arch arm64  cross build, e.g. for a Raspberry Pi: against an arm64 Debian that is unpacked into build/arm64_root
TEXT
      ;;
    licenses) cat <<'TEXT'
./marco licenses
What Marco depends on, its versions on this machine and its licences, checked against the packages' copyright files.
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
