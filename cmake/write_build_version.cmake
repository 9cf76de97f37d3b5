# cmake -DSOURCE=... -DVERSION=... -DTEMPLATE=... -DTARGET=... -P: writes the source that knows version and commit, and
# touches it only when they change.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty=+ --abbrev=12 --exclude=*
                OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(COMMIT "")
endif()
configure_file(${TEMPLATE} ${TARGET} @ONLY)
