# What Marco adds to lcm_tools/cmake/targets.cmake: Eigen among the precompiled headers, and the front door's installation.
set(MARCO_MORE_HEADERS <Eigen/Core> <Eigen/Geometry> <Eigen/LU>)
set(MARCO_COMMON_TARGETS Eigen3::Eigen)
include(${CMAKE_CURRENT_LIST_DIR}/../lcm_tools/cmake/targets.cmake)

# The front door and what it reads, laid out as in the sources. Debian's `marco` is a window manager: ours is marco-robot.
function(marco_install_front_door)
  set(share ${CMAKE_INSTALL_DATADIR}/marco-robot)
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/marco DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME marco-robot)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/config DESTINATION ${share})
  install(PROGRAMS ${MARCO_ISOLATED} DESTINATION ${share}/tests/support)
  foreach(script packages build help demo)
    install(FILES ${PROJECT_SOURCE_DIR}/tools/${script}.sh DESTINATION ${share}/tools)
  endforeach()
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/record.sh DESTINATION ${share}/tools)
  install(FILES ${PROJECT_SOURCE_DIR}/tools/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          RENAME marco-robot)
  # $MARCO_ROOT/marco in procman scripts.
  file(RELATIVE_PATH to_bin /${share} /${CMAKE_INSTALL_BINDIR}/marco-robot)
  file(CREATE_LINK ${to_bin} ${PROJECT_BINARY_DIR}/marco SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/marco DESTINATION ${share})
  # All programs are there by now.
  get_property(programs GLOBAL PROPERTY MARCO_PROGRAMS)
  if(CMAKE_CROSSCOMPILING)
    return()
  endif()
  list(JOIN programs " " programs)
  install(CODE "set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    execute_process(COMMAND ${PROJECT_SOURCE_DIR}/tools/man.sh \${prefix}/${CMAKE_INSTALL_BINDIR} \${prefix}/${CMAKE_INSTALL_MANDIR}/man1 marco-robot ${programs}
                    COMMAND_ERROR_IS_FATAL ANY)")
endfunction()
