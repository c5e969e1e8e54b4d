# Run by cpack between installing every component into a folder of its own and packing these: what Debian's policy
# wants otherwise than cmake --install leaves it, which serves any system.
file(GLOB packages LIST_DIRECTORIES true ${CPACK_TEMPORARY_DIRECTORY}/*)

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

foreach(package IN LISTS packages)
  # Where Debian's zsh, Python and systemd look.
  move(${package} usr/share/zsh/site-functions usr/share/zsh/vendor-completions)
  file(GLOB python RELATIVE ${package} ${package}/usr/lib/python3.*)
  if(python)
    move(${package} ${python} usr/lib/python3)
  endif()
  move(${package} usr/lib/systemd lib/systemd)
  run(find ${package} -type d -empty -delete)
  # Neither the name nor the time of what is compressed, which differs between builds.
  file(GLOB_RECURSE texts ${package}/usr/share/man/*.1 ${package}/usr/share/doc/changelog
    ${package}/usr/share/doc/*/changelog)
  if(texts)
    run(gzip --best --no-name ${texts})
  endif()
  run(find ${package} -exec touch --no-dereference --date=@$ENV{SOURCE_DATE_EPOCH} {} +)
  # Whatever the umask of who built it.
  run(chmod -R u=rwX,go=rX ${package})
endforeach()
