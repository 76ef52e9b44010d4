// qcOutput in C++.
#include "common/bullet/written_file.h"

#include "common/output_file.h"

bool qcWriteFile(const std::string& path, const std::function<void(std::FILE*)>& write, std::string* message)
{
    qcOutput output;
    qcMessage failure;
    bool written = qcOutput_Open(path.c_str(), &output, &failure);
    if (written)
    {
        write(output.stream);
        written = qcOutput_Commit(&output, &failure);
    }
    if (!written)
        *message = failure.text;
    return written;
}
