# What `cmake --install` and `cpack` put where: programs, models/ and settings/ in one folder, where
# programs find them (common/model/model_name.h), with links powderkeg-NAME to the programs. Three
# components, of which cpack makes a Debian package each: actor, learner, tools.
include(GNUInstallDirs)

set(home lib/powderkeg)
if(TORCH_INSTALL_PREFIX AND NOT TORCH_INSTALL_PREFIX STREQUAL "/usr" AND TARGET learner)
  # One that is not the system's is found where it was.
  set_target_properties(learner PROPERTIES INSTALL_RPATH ${TORCH_INSTALL_PREFIX}/lib)
endif()
set(powderkeg_learner_programs learner keys)
set(powderkeg_actor_programs actor)
set(powderkeg_tools_programs arena agent_server view replay check_run conformance)
foreach(component learner actor tools)
  foreach(program ${powderkeg_${component}_programs})
    if(TARGET ${program})
      set(link ${CMAKE_BINARY_DIR}/links/powderkeg-${program})
      file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/links)
      file(CREATE_LINK ../${home}/bin/${program} ${link} SYMBOLIC)
      install(TARGETS ${program} RUNTIME DESTINATION ${home}/bin COMPONENT ${component})
      install(FILES ${link} DESTINATION bin COMPONENT ${component})
      install(FILES ${CMAKE_SOURCE_DIR}/build/docs/man/man1/powderkeg-${program}.1  # deploy/docs man
        DESTINATION share/man/man1 COMPONENT ${component} OPTIONAL)
    endif()
  endforeach()
endforeach()
# The runs of the service are those that tools look for.
file(CREATE_LINK /var/lib/powderkeg/runs ${CMAKE_BINARY_DIR}/links/runs SYMBOLIC)
install(FILES ${CMAKE_BINARY_DIR}/links/runs DESTINATION ${home} COMPONENT tools)
install(DIRECTORY models DESTINATION ${home} COMPONENT tools)
if(TARGET learner)
  file(GLOB settings deploy/*.textproto)
  install(FILES ${settings} DESTINATION ${home}/settings COMPONENT learner)
  install(FILES deploy/systemd/powderkeg-learner@.service
    DESTINATION lib/systemd/system COMPONENT learner)
endif()
install(FILES deploy/systemd/powderkeg-actor@.service
  DESTINATION lib/systemd/system COMPONENT actor)
foreach(component learner actor)
  install(FILES deploy/systemd/sysusers.conf RENAME powderkeg-${component}.conf
    DESTINATION lib/sysusers.d COMPONENT ${component})
endforeach()
foreach(component learner actor tools)
  install(FILES LICENSE RENAME copyright
    DESTINATION share/doc/powderkeg-${component} COMPONENT ${component})
endforeach()

set(this_machine_only "these programs are for processors like this machine's (POWDERKEG_NATIVE=ON)")
if(POWDERKEG_NATIVE)
  install(CODE "message(NOTICE \"powderkeg: ${this_machine_only}; deploy/packages builds for any\")"
    ALL_COMPONENTS)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL actor tools)
if(TARGET learner)
  list(APPEND CPACK_COMPONENTS_ALL learner)
endif()
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PACKAGE_CONTACT "the Powderkeg developers <powderkeg@localhost>")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LEARNER_PACKAGE_DEPENDS libopenblas0-pthread)  # faster than any other BLAS
set(CPACK_DEBIAN_LEARNER_PACKAGE_RECOMMENDS powderkeg-tools)
set(CPACK_DEBIAN_LEARNER_DESCRIPTION
  "learner of Pommerman by distributed self-play\n Takes in the games of its actors, trains, and hands out weights.")
set(CPACK_DEBIAN_ACTOR_DESCRIPTION
  "actor of Pommerman by distributed self-play\n Plays games for a learner, wherever that is.")
set(CPACK_DEBIAN_TOOLS_DESCRIPTION
  "Pommerman agents, matches and viewers\n Trained agents, served or measured, and games in the browser.")
foreach(component LEARNER ACTOR)
  set(CPACK_DEBIAN_${component}_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/deploy/systemd/postinst)
endforeach()
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_LIST_DIR}/cpack_check.cmake)
if(POWDERKEG_NATIVE)
  set(CPACK_POWDERKEG_REFUSED "${this_machine_only}")
endif()
include(CPack)
