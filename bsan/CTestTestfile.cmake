# CMake generated Testfile for 
# Source directory: /tmp/core
# Build directory: /tmp/core/bsan
# 
# This file includes the relevant testing commands required for 
# testing this directory and lists subdirectories to be tested as well.
subdirs("lib")
subdirs("plugins")
subdirs("apps")
subdirs("data")
subdirs("tests")
