// Members of a JSON report.
#ifndef QC_TESTS_TOOLS_JSON_REPORT_H
#define QC_TESTS_TOOLS_JSON_REPORT_H

#include <check.h>
#include <json-c/json.h>
#include <stdint.h>

static inline json_object* Parse(const char* text)
{
    enum json_tokener_error error;
    json_object* object = json_tokener_parse_verbose(text, &error);
    ck_assert_msg(error == json_tokener_success, "%s in: %s", json_tokener_error_desc(error), text);
    return object;
}

static inline json_object* Get(json_object* object, const char* name)
{
    json_object* member;
    ck_assert_msg(json_object_object_get_ex(object, name, &member), "no %s", name);
    return member;
}

static inline uint64_t GetNumber(json_object* object, const char* name)
{
    json_object* member = Get(object, name);
    ck_assert_msg(json_object_is_type(member, json_type_int), "%s is not a whole number", name);
    return json_object_get_uint64(member);
}

#endif
