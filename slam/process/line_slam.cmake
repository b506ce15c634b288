# The process of the line SLAM; the room's CMakeLists.txt includes this.
marco_library(
  line_slam_process
  SOURCES
  process/line_checkpoint.cpp
  process/line_journal.cpp
  process/line_lcm_adapter.cpp
  DEPENDS
  marco::line_slam
  marco::common_process
  marco::lcmtypes
  PRIVATE
  nlohmann_json::nlohmann_json)
marco_executable(marco-line-slam SOURCES process/line_main.cpp DEPENDS marco::line_slam_process)
