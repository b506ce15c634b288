#pragma once

#include "viewer/process/inputs.hpp"

namespace marco::viewer {

/// The program `marco-viewer`, also `./marco render`: reads models and map folders, writes one
/// picture, film, vector page or walk (`walk MODEL`: by letters read from stdin, with a picture
/// after each), says on stdout what it wrote and on stderr what it skipped.
/// @returns the process's exit code: 0 only when the picture was written.
/// @throws what a main should report by process::run_main.
int run_viewer(int argc, const char* const* argv, const FileReaders& readers);

}  // namespace marco::viewer
