// Writes files as a whole: readers see the old file or all of the new one.
#ifndef QC_GLUE_FRACTURE_NEW_FILE_H
#define QC_GLUE_FRACTURE_NEW_FILE_H

#include <string>
#include <vector>

/// Replaces a file, or makes one. A symbolic link stays: the file behind it is replaced. What is no file, as a pipe, is
/// written itself. Returns the reason why the file could not be written, and is as it was, or an empty text.
std::string qcWriteFile(const char* path, const std::vector<char>& bytes);

#endif
