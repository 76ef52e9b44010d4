// The main function of a test program of several files: runs the one that the argument names, as `test_mesh_shape`.
#include "support/test_group.h"

#include <cstdio>
#include <string>

int main(int argc, char** argv)
{
    std::string names;
    for (const qcTestFile* file = qcTestFile::first; file != nullptr; file = file->next)
    {
        std::string name(file->path);
        name.erase(0, name.rfind('/') + 1);
        name.resize(name.rfind('.'));
        if (argc == 2 && name == argv[1])
            return file->run();
        names += " " + name;
    }
    std::fprintf(stderr, "Give one of:%s\n", names.c_str());
    return 2;
}
