// Decimal text to the nearest float or double, without a locale.
// The quick path is Clinger's: How to Read Floating Point Numbers Accurately, PLDI 1990.
#include "common/mesh_io/mesh_parser.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    // No double or point halfway between two has more digits than 767; a nonzero digit beyond says "a bit more".
    qc_maxDigits = 800,
    // An exponent beyond it is as good as this one: qc_maxDigits digits are then far out of range too.
    qc_exponentLimit = 100000
};

/// mantissa * 10^exponent, if `digits` (from the first that is not 0) fit the mantissa.
typedef struct Decimal
{
    bool negative;
    uint64_t mantissa;
    int64_t exponent;
    size_t digits;
    const char* text;    ///< behind the sign
    const char* textEnd; ///< before the exponent
} Decimal;

static bool IsDigit(char c)
{
    return c >= '0' && c <= '9';
}

static const char* SkipSign(const char* text, const char* end, bool* negative)
{
    *negative = text < end && *text == '-';
    return text < end && (*text == '-' || *text == '+') ? text + 1 : text;
}

static bool ScanExponent(const char* text, const char* end, int64_t* exponent)
{
    bool negative;
    text = SkipSign(text, end, &negative);
    if (text == end)
        return false;
    int64_t value = 0;
    for (; text < end; ++text)
    {
        if (!IsDigit(*text))
            return false;
        // Saturated, but still more than any file's digits can balance.
        if (value < INT64_MAX / 16)
            value = 10 * value + (*text - '0');
    }
    *exponent = negative ? -value : value;
    return true;
}

static bool ScanDecimal(const char* text, const char* end, Decimal* decimal)
{
    *decimal = (Decimal){0};
    decimal->text = SkipSign(text, end, &decimal->negative);
    bool any = false, point = false;
    const char* p = decimal->text;
    for (; p < end; ++p)
    {
        if (*p == '.' && !point)
        {
            point = true;
            continue;
        }
        if (!IsDigit(*p))
            break;
        any = true;
        decimal->exponent -= point;
        if (decimal->digits > 0 || *p != '0')
            ++decimal->digits;
        // Beyond 19 digits it wraps, and is not used.
        decimal->mantissa = 10 * decimal->mantissa + (uint64_t)(*p - '0');
    }
    decimal->textEnd = p;
    if (!any)
        return false;
    if (p == end)
        return true;
    int64_t exponent;
    if ((*p != 'e' && *p != 'E') || !ScanExponent(p + 1, end, &exponent))
        return false;
    decimal->exponent += exponent;
    return true;
}

static bool ConvertQuickly(const Decimal* decimal, double* value)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    // One rounding only: both numbers are exact, and so is the arithmetic's precision.
    if (FLT_EVAL_METHOD != 0 || decimal->digits > 19 || decimal->mantissa > (UINT64_C(1) << 53) ||
        decimal->exponent < -22 || decimal->exponent > 22)
        return false;
    double mantissa = (double)decimal->mantissa;
    *value = decimal->exponent < 0 ? mantissa / powers[-decimal->exponent] : mantissa * powers[decimal->exponent];
    return true;
}

/// The number without its decimal point, which is the only thing in it that a locale could change.
static void WriteForLibrary(const Decimal* decimal, char* buffer, size_t size)
{
    size_t length = 0, digits = 0;
    bool more = false;
    for (const char* p = decimal->text; p < decimal->textEnd; ++p)
    {
        if (*p == '.' || (digits == 0 && *p == '0'))
            continue;
        ++digits;
        if (length < qc_maxDigits)
            buffer[length++] = *p;
        else
            more = more || *p != '0';
    }
    int64_t exponent = decimal->exponent + (int64_t)(digits - length);
    if (more)
    {
        buffer[length++] = '1';
        --exponent;
    }
    if (length == 0)
        buffer[length++] = '0';
    if (exponent > qc_exponentLimit)
        exponent = qc_exponentLimit;
    if (exponent < -qc_exponentLimit)
        exponent = -qc_exponentLimit;
    snprintf(buffer + length, size - length, "e%d", (int)exponent);
}

bool qcParseDouble(const char* text, const char* end, double* value)
{
    Decimal decimal;
    if (!ScanDecimal(text, end, &decimal))
        return false;
    double magnitude;
    if (!ConvertQuickly(&decimal, &magnitude))
    {
        char buffer[qc_maxDigits + 16];
        WriteForLibrary(&decimal, buffer, sizeof buffer);
        magnitude = strtod(buffer, NULL);
    }
    *value = decimal.negative ? -magnitude : magnitude;
    return true;
}

bool qcParseFloat(const char* text, const char* end, float* value)
{
    Decimal decimal;
    if (!ScanDecimal(text, end, &decimal))
        return false;
    double rounded;
    bool quick = ConvertQuickly(&decimal, &rounded);
    if (quick)
    {
        // Rounding twice goes wrong only where the first rounding lands halfway between two floats. Numbers that
        // convert quickly are all within the range where a float has 24 bits.
        uint64_t bits;
        memcpy(&bits, &rounded, sizeof bits);
        quick = (bits & 0x1fffffff) != 0x10000000;
    }
    float magnitude;
    if (quick)
        magnitude = (float)rounded;
    else
    {
        char buffer[qc_maxDigits + 16];
        WriteForLibrary(&decimal, buffer, sizeof buffer);
        magnitude = strtof(buffer, NULL);
    }
    *value = decimal.negative ? -magnitude : magnitude;
    return true;
}

bool qcParseInteger(const char* text, const char* end, int64_t* value)
{
    bool negative;
    text = SkipSign(text, end, &negative);
    if (text == end || end - text > 18)
        return false;
    int64_t magnitude = 0;
    for (; text < end; ++text)
    {
        if (!IsDigit(*text))
            return false;
        magnitude = 10 * magnitude + (*text - '0');
    }
    *value = negative ? -magnitude : magnitude;
    return true;
}
