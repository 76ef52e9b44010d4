// Runs a fuzzer's function on files, in place of libFuzzer: a plain program for any compiler.
//   PROGRAM FILE_OR_FOLDER...     prints the number of inputs; fails if there is none
#include "fuzz/fuzz.h"

#include <dirent.h>
#include <string.h>

static size_t s_inputs;

static int Fail(const char* path)
{
    perror(path);
    return 1;
}

static int RunFile(const char* path, FILE* file)
{
    uint8_t* data = NULL;
    size_t size = 0, capacity = 0, count;
    do
    {
        if (size == capacity)
            data = realloc(data, capacity = 2 * capacity + 4096);
        if (data == NULL)
            return Fail(path);
        count = fread(data + size, 1, capacity - size, file);
        size += count;
    } while (count > 0);
    int status = ferror(file) ? Fail(path) : 0;
    // Exactly as large as the input, so that a sanitizer sees a read beyond it.
    uint8_t* input = malloc(size > 0 ? size : 1);
    if (input == NULL)
        return Fail(path);
    memcpy(input, data, size);
    free(data);
    if (status == 0)
        LLVMFuzzerTestOneInput(input, size);
    free(input);
    s_inputs++;
    return status;
}

static int RunPath(const char* path)
{
    DIR* folder = opendir(path);
    if (folder == NULL)
    {
        FILE* file = fopen(path, "rb");
        if (file == NULL)
            return Fail(path);
        // A broken claim ends the program: the line before it names the input.
        fprintf(stderr, "%s\n", path);
        int status = RunFile(path, file);
        fclose(file);
        return status;
    }
    int status = 0;
    for (const struct dirent* entry; (entry = readdir(folder)) != NULL;)
    {
        char name[4096];
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] != '.')
            status |= RunPath(name);
    }
    closedir(folder);
    return status;
}

int main(int argc, char** argv)
{
    int status = 0;
    for (int i = 1; i < argc; i++)
        status |= RunPath(argv[i]);
    printf("%zu inputs\n", s_inputs);
    return s_inputs == 0 ? 1 : status;
}
