# CMake generated Testfile for 
# Source directory: /tmp/core/data
# Build directory: /tmp/core/bsan/data
# 
# This file includes the relevant testing commands required for 
# testing this directory and lists subdirectories to be tested as well.
