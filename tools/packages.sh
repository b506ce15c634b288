# Which Debian packages a command needs, and how they come; read by ./marco, whose root, here, say and fail it uses.

# By purpose; `a|b`: the first that this system has. Each has a row in docs/dependencies.txt.
declare -A packages_for=(
  [core]="g++ cmake ninja-build pkg-config liblcm-dev liblcm-bin libglib2.0-dev libeigen3-dev libspdlog-dev
    libtomlplusplus-dev libcli11-dev nlohmann-json3-dev zlib1g-dev libpng-dev libjpeg-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
    libopencv-videoio-dev libmeshoptimizer-dev libncurses-dev libpango1.0-dev libbz2-dev liblz4-dev libzstd-dev libsqlite3-dev"
  [viewer]="libosmesa6-dev|libegl-dev libosmesa6|libgl1-mesa-dri libgl-dev libgl2ps-dev"
  [simulator]="libembree-dev"
  [network]="iproute2 procps"
  [bridge]="libboost-dev"
  [page]="libboost-dev libssl-dev libjs-three libqrencode-dev"
  [replay]="liblcm-bin"
  [many]="python3"
  [python]="python3-dev pybind11-dev python3-numpy"
  [test]="libgtest-dev libgmock-dev libassimp-dev libpoppler-cpp-dev libegl-dev libgl1-mesa-dri python3 python3-venv python3-pip python3-setuptools python3-wheel tmux ccache lld"
  [peers]="libmrpt-hwdrivers-dev pcl-tools python3-ezdxf python3-open3d python3-rosbag python3-rosmaster python3-rospy python3-geometry-msgs python3-nav-msgs python3-tf2-msgs chromium"
  [npm]="nodejs npm"
  [bench]="libbenchmark-dev python3"
  [sanitizers]="clang libclang-rt-dev"
  [lint]="clang-format clang-tidy clang git"
  [docs]="codespell doxygen"
  [lines]="git python3"
  [coverage]="llvm"
  [soak]="python3"
  [faults]="libfaketime"
  [package]="dpkg-dev file"
  [cross]="g++-aarch64-linux-gnu qemu-user-static mmdebstrap"
  [valgrind]="valgrind"
)

# What the command at hand needs: names of packages_for.
needs=(core)
need() { needs+=("$@"); }

all_packages() { echo ${packages_for[*]//|/ } | tr ' ' '\n' | sort -u; }

# $@: packages, perhaps `a|b`. Sets `missing` to those that are not installed; one call of dpkg-query.
find_missing() {
  local installed package
  installed=" $(dpkg-query -W -f='${db:Status-Status}:${Package} ' ${*//|/ } 2>/dev/null || true)"
  missing=()
  for package in "$@"; do
    local one
    for one in ${package//|/ }; do [[ $installed == *" installed:$one "* ]] && continue 2; done
    missing+=("$package")
  done
}

# Of each `a|b` in `missing` the first that apt knows, or else the first.
choose_alternatives() {
  local i one
  for i in "${!missing[@]}"; do
    [[ ${missing[i]} == *'|'* ]] || continue
    for one in ${missing[i]//|/ } ${missing[i]%%|*}; do
      apt-cache show "$one" >/dev/null 2>&1 && break
    done
    missing[i]=$one
  done
}

# The commands for root, where this could not run them.
say_by_hand() {
  choose_alternatives
  cat >&2 <<TEXT
marco: Debian packages are missing that only root can install. Run this once as root:

  apt-get update && apt-get install -y --no-install-recommends ${missing[*]}

Then give the same ./marco command again; it needs no root.
TEXT
  exit 1
}

# $1: what the command needs, one package a word. Whether they were all there the last time, and dpkg did nothing since.
were_there() {
  [ -f "$stamp" ] && [ ! /var/lib/dpkg/status -nt "$stamp" ] && [ "$(<"$stamp")" = "$1" ]
}

install_packages() {
  local wanted=() name stamp missing sudo=()
  for name in "${needs[@]}"; do wanted+=(${packages_for[$name]}); done
  stamp="$root/build/packages_$(IFS=_; echo "${needs[*]}")"
  were_there "${wanted[*]}" && return
  if ! command -v dpkg-query >/dev/null; then
    [ -f "$stamp" ] || say "this is not Debian; Marco needs the equivalents of these packages: ${wanted[*]}"
  else
    find_missing "${wanted[@]}"
    if [ ${#missing[@]} -gt 0 ]; then
      if [ "$(id -u)" != 0 ]; then
        # sudo may ask for a password, where there is somebody to ask.
        command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; } || say_by_hand
        sudo=(sudo)
      fi
      command -v apt-get >/dev/null || fail "these Debian packages are missing, and there is no apt-get: ${missing[*]}"
      say "installing ${#missing[@]} packages: ${missing[*]}"
      "${sudo[@]}" apt-get update -qq || say "apt-get update failed: using the existing package lists"
      choose_alternatives
      "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" |
        grep -E '^(Setting up|E:|Err)' >&2 || true
      find_missing "${wanted[@]}"
      [ ${#missing[@]} = 0 ] || [ ${#sudo[@]} = 0 ] || say_by_hand  # sudo would not
      [ ${#missing[@]} = 0 ] || fail "apt could not install: ${missing[*]}"
    fi
  fi
  { mkdir -p "$root/build" && echo "${wanted[*]}" >"$stamp"; } 2>/dev/null || true  # somebody else's checkout
}
