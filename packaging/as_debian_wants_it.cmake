# Run by cpack between installing every component into a folder of its own and packing these: what Debian's policy
# wants otherwise than cmake --install leaves it, which serves any system, and what packages alone have.

# run(COMMAND ARGUMENT ...)
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# move(PACKAGE FROM TO): a folder of it, if it has it.
function(move package from to)
  if(EXISTS ${package}/${from})
    get_filename_component(parent ${package}/${to} DIRECTORY)
    file(MAKE_DIRECTORY ${parent})
    file(RENAME ${package}/${from} ${package}/${to})
  endif()
endfunction()

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(package ${CPACK_TEMPORARY_DIRECTORY}/${component})
  string(TOUPPER ${component} COMPONENT)
  file(COPY ${CMAKE_CURRENT_LIST_DIR}/copyright ${CMAKE_CURRENT_LIST_DIR}/changelog
    DESTINATION ${package}/usr/share/doc/${CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME})
  if(component STREQUAL "program")
    file(COPY ${CMAKE_CURRENT_LIST_DIR}/roomwise/roomwise.service DESTINATION ${package}/lib/systemd/system)
    # For who serves many homes behind a proxy: to be copied and filled in.
    file(COPY ${CMAKE_CURRENT_LIST_DIR}/homes/haproxy.cfg ${CMAKE_CURRENT_LIST_DIR}/homes/roomwise-homes@.service
      DESTINATION ${package}/usr/share/doc/roomwise/examples)
  endif()
  # Where Debian's zsh and Python look.
  move(${package} usr/share/zsh/site-functions usr/share/zsh/vendor-completions)
  file(GLOB python RELATIVE ${package} ${package}/usr/lib/python3.*)
  if(python)
    move(${package} ${python} usr/lib/python3)
  endif()
  run(find ${package} -type d -empty -delete)
  # Neither the name nor the time of what is compressed, which differs between builds.
  file(GLOB_RECURSE texts ${package}/usr/share/man/*.1* ${package}/usr/share/doc/changelog)
  run(gzip --best --no-name ${texts})
  run(find ${package} -exec touch --no-dereference --date=@$ENV{SOURCE_DATE_EPOCH} {} +)
  # Whatever the umask of who built it.
  run(chmod -R u=rwX,go=rX ${package})
endforeach()
