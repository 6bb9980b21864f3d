# Run at installation: the service's unit with the paths of this installation, and its configuration where there is none yet.
# SPDX-License-Identifier: BSD-3-Clause
set(prefix ${CMAKE_INSTALL_PREFIX})
set(bindir ${prefix}/bin)
set(sysconfdir ${prefix}/etc)
if(prefix MATCHES "^/usr(/local)?/?$")
  set(sysconfdir /etc)
endif()
set(config ${sysconfdir}/kintsugi/collector.yaml)
configure_file(${CMAKE_CURRENT_LIST_DIR}/kintsugi-collector.service.in
  $ENV{DESTDIR}${prefix}/lib/systemd/system/kintsugi-collector.service @ONLY)
message(STATUS "Installing: $ENV{DESTDIR}${prefix}/lib/systemd/system/kintsugi-collector.service")
if(EXISTS $ENV{DESTDIR}${config})
  message(STATUS "Kept: $ENV{DESTDIR}${config}")
else()
  file(INSTALL ${CMAKE_CURRENT_LIST_DIR}/collector.yaml DESTINATION ${sysconfdir}/kintsugi TYPE FILE)
endif()
