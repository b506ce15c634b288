# Debian packages by CPack, one for each component: `./marco package` calls it. debian/ has their scripts, the unit and
# the copyright; what only packages have is excluded from a whole `cmake --install`.
set(debian ${CMAKE_CURRENT_LIST_DIR}/debian)
set(MARCO_PACKAGES lcm-tools marco-robot marco-robot-viewer libmarco-robot-dev marco-robot-doc)
if(MARCO_HAS_PYTHON)
  list(APPEND MARCO_PACKAGES python3-marco-robot)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
  file(CREATE_LINK ../../marco-robot/python/marco ${PROJECT_BINARY_DIR}/packages/marco SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/packages/marco DESTINATION lib/python3/dist-packages COMPONENT python3-marco-robot EXCLUDE_FROM_ALL)
endif()
install(FILES ${debian}/marco-robot.service ${debian}/marco-robot-loopback.service DESTINATION lib/systemd/system COMPONENT marco-robot EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_SOURCE_DIR}/config/60-marco.rules DESTINATION lib/udev/rules.d COMPONENT marco-robot EXCLUDE_FROM_ALL)
foreach(package ${MARCO_PACKAGES})
  install(FILES ${debian}/copyright DESTINATION share/doc/${package} COMPONENT ${package} EXCLUDE_FROM_ALL)
  if(EXISTS ${debian}/${package}.overrides)
    install(FILES ${debian}/${package}.overrides DESTINATION share/lintian/overrides RENAME ${package} COMPONENT ${package} EXCLUDE_FROM_ALL)
  endif()
  install(CODE "if(DEFINED ENV{MARCO_PACKAGE_VERSION})\nexecute_process(COMMAND ${debian}/finish.sh \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\" ${package}
                COMMAND_ERROR_IS_FATAL ANY)\nendif()" COMPONENT ${package} EXCLUDE_FROM_ALL)
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME marco-robot)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each has its own
set(CPACK_PACKAGE_VENDOR "The Marco developers")
set(CPACK_COMPONENTS_ALL ${MARCO_PACKAGES})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# A package needs the others of its own build.
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
if(CMAKE_CROSSCOMPILING)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
endif()

# marco_package(NAME SUMMARY one line TEXT ... [ALL] [FIELD value]...): fields as in CPACK_DEBIAN_<NAME>_PACKAGE_<FIELD>.
function(marco_package name)
  cmake_parse_arguments(arg "ALL" "SUMMARY;TEXT;SECTION;DEPENDS;RECOMMENDS;SUGGESTS" "OF_OURS;CONTROL_EXTRA" ${ARGN})
  string(TOUPPER ${name} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${arg_SUMMARY}\n${arg_TEXT}" PARENT_SCOPE)
  set(CPACK_COMPONENT_${upper}_DEPENDS ${arg_OF_OURS} PARENT_SCOPE)
  foreach(field SECTION DEPENDS RECOMMENDS SUGGESTS CONTROL_EXTRA)
    if(arg_${field})
      set(CPACK_DEBIAN_${upper}_PACKAGE_${field} "${arg_${field}}" PARENT_SCOPE)
    endif()
  endforeach()
  if(arg_ALL)
    set(CPACK_DEBIAN_${upper}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
    set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS OFF PARENT_SCOPE)
  endif()
endfunction()

if(MARCO_HAS_PYTHON)
  math(EXPR python3_next "${Python3_VERSION_MINOR} + 1")
endif()
marco_package(lcm-tools SUMMARY "spy, log tools and process manager for LCM"
  TEXT "marco-spy shows live traffic or a recording, marco-log looks into
recordings, cuts, repairs and converts them, marco-relay joins hosts that
multicast does not reach, and marco-procman starts and watches a robot's
processes. Of any system that talks over LCM." SECTION utils SUGGESTS marco-robot)
marco_package(marco-robot OF_OURS lcm-tools SUMMARY "indoor maps from a 2D laser"
  TEXT "Makes a floor plan, the path that was driven and a 3D model from a recording
or a running robot. Drivers of lasers and bases, SLAM, a simulator, and the
command marco-robot in front of them all."
  DEPENDS "adduser, iproute2, liblcm-bin, procps, python3" RECOMMENDS "marco-robot-viewer, udev" SUGGESTS "marco-robot-doc, python3-marco-robot"
  CONTROL_EXTRA ${debian}/postinst ${debian}/prerm ${debian}/postrm)
marco_package(marco-robot-viewer OF_OURS marco-robot SUMMARY "pictures, page in the browser and cameras of marco-robot"
  TEXT "The programs that stand on OpenCV and OpenGL: pictures of maps and models,
the page in the browser that shows and steers a robot, photographs on a
model, cameras and their simulation."
  RECOMMENDS "libgl1-mesa-dri, libjs-three")
marco_package(python3-marco-robot OF_OURS lcm-tools SUMMARY "recordings, maps and live robots of marco-robot for Python 3"
  TEXT "The module marco: recordings as numpy arrays, maps, scan matching, a live
robot." SECTION python
  DEPENDS "python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}), python3 (<< ${Python3_VERSION_MAJOR}.${python3_next}), python3-numpy")
marco_package(libmarco-robot-dev SUMMARY "libraries, headers and messages of marco-robot"
  TEXT "Static libraries for find_package(marco): scan matching, SLAM, 3D models,
recordings, drivers, LCM messages."
  SECTION libdevel
  DEPENDS "libeigen3-dev, libjpeg-dev, liblcm-dev, libglib2.0-dev, libmeshoptimizer-dev, libpng-dev, libspdlog-dev,\
 libtomlplusplus-dev, nlohmann-json3-dev, zlib1g-dev, libbz2-dev, liblz4-dev, libsqlite3-dev, libzstd-dev"
  RECOMMENDS "libembree-dev, libgl2ps-dev, libncurses-dev, libopencv-core-dev, libopencv-imgcodecs-dev, libopencv-imgproc-dev,\
 libopencv-videoio-dev, libosmesa6-dev, libpango1.0-dev, libegl-dev, cmake, pkg-config")
marco_package(marco-robot-doc ALL SUMMARY "manual and examples of marco-robot"
  TEXT "Tutorial, commands, settings, messages and figures in Markdown, a recording,
and programs that use the libraries."
  SECTION doc)
include(CPack)
