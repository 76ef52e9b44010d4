// What the results depend on: the machine, its GL devices, and the versions of everything.
#define _GNU_SOURCE
#include "report/report.h"

#include "quickcullide/quickcullide.h"

#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/// The value of the first line "NAME...SEPARATOR value" of a file, without quotes around it; false: there is none.
static bool FindValue(const char* path, const char* name, char separator, char value[256])
{
    FILE* stream = fopen(path, "r");
    char line[1024];
    bool found = false;
    while (stream != NULL && !found && fgets(line, sizeof line, stream) != NULL)
    {
        char* text = strchr(line, separator);
        if (text == NULL || strncmp(line, name, strlen(name)) != 0)
            continue;
        text += 1 + strspn(text + 1, " \t\"");
        text[strcspn(text, "\"\n")] = 0;
        snprintf(value, 256, "%.255s", text);
        found = true;
    }
    if (stream != NULL)
        fclose(stream);
    return found;
}

static void WriteRow(FILE* page, const char* name, const char* value)
{
    fputs("<tr><th>", page);
    qcReport_WriteText(page, name);
    fputs("</th><td>", page);
    qcReport_WriteText(page, value);
    fputs("</td></tr>\n", page);
}

static void WriteDevice(FILE* page, const char* name, qcDeviceKind kind)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    qcDevice* device = NULL;
    qcDeviceInfo info;
    char text[512];
    if (qcDevice_Create(&def, &device) == qc_statusOk && qcDevice_GetInfo(device, &info) == qc_statusOk)
        snprintf(text, sizeof text, "%s; OpenGL %s%s", info.renderer, info.version,
                 info.software ? " (on the CPU)" : "");
    else
        snprintf(text, sizeof text, "does not open here: %.400s", qcLastMessage());
    qcDevice_Destroy(device);
    WriteRow(page, name, text);
}

static void WriteVersions(FILE* page, const char* revision)
{
    uint32_t version = qcVersion();
    char text[512];
    snprintf(text, sizeof text, "%u.%u.%u%s%s", version / 10000, version / 100 % 100, version % 100,
             revision != NULL ? ", revision " : "", revision != NULL ? revision : "");
    WriteRow(page, "Quick-CULLIDE", text);
#ifdef QC_BULLET_VERSION
    WriteRow(page, "Bullet", QC_BULLET_VERSION);
#endif
#ifdef __clang__
    WriteRow(page, "Compiler", __VERSION__);
#else
    WriteRow(page, "Compiler", "gcc " __VERSION__);
#endif
}

void qcReport_WriteMachine(FILE* page, const char* revision)
{
    char text[512], value[256];
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (!FindValue("/proc/cpuinfo", "model name", ':', value))
        strcpy(value, "unknown");
    snprintf(text, sizeof text, "%s, %ld %s", value, cores, cores == 1 ? "core" : "cores");
    WriteRow(page, "Processor", text);
    double bytes = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    snprintf(text, sizeof text, "%.1f GiB", bytes / (1024.0 * 1024.0 * 1024.0));
    WriteRow(page, "Memory", text);
    struct utsname system;
    if (uname(&system) == 0)
    {
        bool hasName = FindValue("/etc/os-release", "PRETTY_NAME", '=', value);
        snprintf(text, sizeof text, "%s%s%s %s, %s", hasName ? value : "", hasName ? "; " : "", system.sysname,
                 system.release, system.machine);
        WriteRow(page, "System", text);
    }
    WriteDevice(page, "GPU (EGL)", qc_deviceEgl);
    WriteDevice(page, "OSMesa", qc_deviceOsmesa);
    WriteDevice(page, "EGL surfaceless", qc_deviceSurfaceless);
    WriteVersions(page, revision);
}
