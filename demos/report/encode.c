// Files as text of an HTML page.
#include "report/report.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

char* qcReport_ReadFile(const char* path, size_t* size, qcMessage* message)
{
    FILE* stream = fopen(path, "rb");
    char* text = NULL;
    size_t length = 0, capacity = 0, got = 1;
    while (stream != NULL && got != 0)
    {
        if (capacity - length < 2)
        {
            capacity = capacity == 0 ? 65536 : 2 * capacity;
            char* larger = realloc(text, capacity);
            if (larger == NULL)
                break;
            text = larger;
        }
        got = fread(text + length, 1, capacity - length - 1, stream);
        length += got;
    }
    bool isRead = stream != NULL && got == 0 && ferror(stream) == 0;
    if (!isRead)
        qcMessage_Fail(message, "%s: %s", path, errno != 0 ? strerror(errno) : "can't be read");
    if (stream != NULL)
        fclose(stream);
    if (!isRead)
    {
        free(text);
        return NULL;
    }
    text[length] = 0;
    *size = length;
    return text;
}

void qcReport_WriteEscaped(FILE* page, const char* text, size_t length)
{
    for (size_t i = 0; i < length; ++i)
    {
        unsigned char c = (unsigned char)text[i];
        switch (c)
        {
            case '&': fputs("&amp;", page); break;
            case '<': fputs("&lt;", page); break;
            case '>': fputs("&gt;", page); break;
            case '"': fputs("&quot;", page); break;
            default:
                if (c >= ' ' || c == '\n' || c == '\t')
                    fputc(c, page);
        }
    }
}

void qcReport_WriteText(FILE* page, const char* text)
{
    qcReport_WriteEscaped(page, text, strlen(text));
}

void qcReport_WriteData(FILE* page, const char* type, const void* bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const uint8_t* b = bytes;
    fprintf(page, "data:%s;base64,", type);
    for (size_t i = 0; i < size; i += 3)
    {
        size_t count = size - i < 3 ? size - i : 3;
        uint32_t group = (uint32_t)b[i] << 16 | (count > 1 ? (uint32_t)b[i + 1] << 8 : 0) | (count > 2 ? b[i + 2] : 0);
        char text[4] = {digits[group >> 18], digits[group >> 12 & 63], count > 1 ? digits[group >> 6 & 63] : '=',
                        count > 2 ? digits[group & 63] : '='};
        fwrite(text, 1, sizeof text, page);
    }
}
