// A file that a demo writes as a whole.
#ifndef QC_DEMOS_COMMON_BULLET_WRITTEN_FILE_H
#define QC_DEMOS_COMMON_BULLET_WRITTEN_FILE_H

#include <cstdio>
#include <functional>
#include <string>

/// Writes a file by qcOutput (common/output_file.h). False with a message: it can't be written, and is as it was.
bool qcWriteFile(const std::string& path, const std::function<void(std::FILE*)>& write, std::string* message);

#endif
