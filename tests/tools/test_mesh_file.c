// The mesh readers: accepted files, exact positions and indices, errors with their line.
#define _DEFAULT_SOURCE
#include "tools/mesh_bytes.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

//  ---- PLY -----------------------------------------------------------------------------------------

START_TEST(every_encoding_gives_the_same_mesh)
{
    static const float positions[4][3] = {{0.1f, -2.5f, 1e-30f}, {3.0f, FLT_MAX, 0.0f}, {1.0f, 2.0f, 3.0f}, {7, 8, 9}};
    static const uint32_t indices[] = {0, 1, 2, 3, 2, 1};
    for (Encoding encoding = 0; encoding < encoding_count; ++encoding)
    {
        Bytes bytes;
        BeginPly(&bytes, encoding,
                 "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 2\nproperty list uchar int vertex_indices\n");
        for (int i = 0; i < 4; ++i)
        {
            for (int axis = 0; axis < 3; ++axis)
                AddFloat(&bytes, positions[i][axis]);
            EndElement(&bytes);
        }
        for (int i = 0; i < 2; ++i)
        {
            AddInteger(&bytes, "uchar", 3);
            for (int corner = 0; corner < 3; ++corner)
                AddInteger(&bytes, "int", indices[3 * i + corner]);
            EndElement(&bytes);
        }
        qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
        ck_assert(!mesh.isDouble);
        ck_assert_uint_eq(mesh.vertexCount, 4);
        ck_assert_mem_eq(mesh.positions, positions, sizeof positions);
        AssertIndices(&mesh, 2, indices);
        qcMesh_Free(&mesh);
    }
}
END_TEST

START_TEST(positions_are_doubles_where_a_float_would_lose_bits)
{
    static const struct
    {
        const char* type;
        bool isDouble;
        int64_t value;
    } cases[] = {{"char", false, -128},       {"int8", false, 127},       {"uchar", false, 255},
                 {"uint8", false, 200},       {"short", false, -32768},   {"int16", false, 32767},
                 {"ushort", false, 65535},    {"uint16", false, 40000},   {"int", true, -2147483647 - 1},
                 {"int32", true, 2147483647}, {"uint", true, 4294967295}, {"uint32", true, 16777217}};
    for (Encoding encoding = 0; encoding < encoding_count; ++encoding)
    {
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        {
            Bytes bytes;
            char declarations[256];
            snprintf(declarations, sizeof declarations,
                     "element vertex 1\nproperty float32 z\nproperty %s x\nproperty float64 nothing\nproperty float y\n"
                     "element face 0\nproperty list uint8 uint32 vertex_index\n",
                     cases[i].type);
            BeginPly(&bytes, encoding, declarations);
            AddFloat(&bytes, 0.1f);
            AddInteger(&bytes, cases[i].type, cases[i].value);
            AddDouble(&bytes, NAN);
            AddFloat(&bytes, -0.3f);
            qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
            ck_assert_int_eq(mesh.isDouble, cases[i].isDouble);
            double position[3];
            for (int axis = 0; axis < 3; ++axis)
                position[axis] = mesh.isDouble ? ((double*)mesh.positions)[axis] : ((float*)mesh.positions)[axis];
            ck_assert_double_eq(position[0], (double)cases[i].value);
            ck_assert_double_eq(position[1], -0.3f);
            ck_assert_double_eq(position[2], 0.1f);
            qcMesh_Free(&mesh);
        }
    }
}
END_TEST

START_TEST(doubles_keep_all_their_bits)
{
    static const double position[3] = {0.1, -1e300, 5e-324};
    for (Encoding encoding = 0; encoding < encoding_count; ++encoding)
    {
        Bytes bytes;
        BeginPly(&bytes, encoding,
                 "element vertex 1\nproperty double x\nproperty float64 y\nproperty double z\n"
                 "element face 0\nproperty list uchar int vertex_indices\n");
        for (int axis = 0; axis < 3; ++axis)
            AddDouble(&bytes, position[axis]);
        EndElement(&bytes);
        qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
        ck_assert(mesh.isDouble);
        ck_assert_mem_eq(mesh.positions, position, sizeof position);
        qcMesh_Free(&mesh);
    }
}
END_TEST

START_TEST(unknown_elements_properties_and_lists_are_skipped)
{
    static const uint32_t indices[] = {2, 1, 0};
    for (Encoding encoding = 0; encoding < encoding_count; ++encoding)
    {
        Bytes bytes;
        BeginPly(&bytes, encoding,
                 "comment made by a test\nobj_info num_cols 512\n"
                 "element camera 2\nproperty short id\nproperty list ushort double weights\n"
                 "element face 1\nproperty uchar flags\nproperty list uchar float texcoord\n"
                 "property list int ushort vertex_index\nproperty int material\n"
                 "element vertex 3\nproperty list uchar short x_history\nproperty float x\nproperty uchar red\n"
                 "property float y\nproperty float z\n"
                 "element edge 1\nproperty int vertex1\nproperty int vertex2\n");
        for (int i = 0; i < 2; ++i)
        {
            AddInteger(&bytes, "short", -5);
            AddInteger(&bytes, "ushort", 2 * i);
            for (int k = 0; k < 2 * i; ++k)
                AddDouble(&bytes, 1.5);
            EndElement(&bytes);
        }
        AddInteger(&bytes, "uchar", 255);
        AddInteger(&bytes, "uchar", 1);
        AddFloat(&bytes, 0.5f);
        AddInteger(&bytes, "int", 3);
        for (int i = 0; i < 3; ++i)
            AddInteger(&bytes, "ushort", indices[i]);
        AddInteger(&bytes, "int", -1);
        EndElement(&bytes);
        for (int i = 0; i < 3; ++i)
        {
            AddInteger(&bytes, "uchar", i);
            for (int k = 0; k < i; ++k)
                AddInteger(&bytes, "short", 77);
            AddFloat(&bytes, (float)i);
            AddInteger(&bytes, "uchar", 9);
            AddFloat(&bytes, (float)i + 0.25f);
            AddFloat(&bytes, (float)i + 0.5f);
            EndElement(&bytes);
        }
        AddInteger(&bytes, "int", 0);
        AddInteger(&bytes, "int", 1);
        EndElement(&bytes);
        qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
        AssertIndices(&mesh, 1, indices);
        ck_assert_uint_eq(mesh.vertexCount, 3);
        for (int i = 0; i < 3; ++i)
        {
            const float* position = (const float*)mesh.positions + 3 * i;
            ck_assert_float_eq(position[0], (float)i);
            ck_assert_float_eq(position[1], (float)i + 0.25f);
            ck_assert_float_eq(position[2], (float)i + 0.5f);
        }
        qcMesh_Free(&mesh);
    }
}
END_TEST

static const char s_square[] = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                               "element face 1\nproperty list uchar int vertex_indices\n";

START_TEST(a_polygon_is_a_fan_around_its_first_corner)
{
    Bytes bytes;
    BeginPly(&bytes, encoding_ascii, s_square);
    AddText(&bytes, "0 0 0\n1 0 0\n1 1 0\n0 1 0\n5 3 0 1 2 0\n");
    qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
    AssertIndices(&mesh, 3, (const uint32_t[]){3, 0, 1, 3, 1, 2, 3, 2, 0});
    qcMesh_Free(&mesh);
}
END_TEST

START_TEST(line_ends_blank_lines_and_the_last_newline_do_not_matter)
{
    static const char text[] = "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\n"
                               "property float z\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\n"
                               "end_header\r\n\r\n 0\t0 0 \r\n1 0 0\r\n\r\n\n1 1 0\r\n3 0 1 2";
    qcMesh mesh = MustRead("named as nothing", text, sizeof text - 1);
    AssertIndices(&mesh, 1, (const uint32_t[]){0, 1, 2});
    qcMesh_Free(&mesh);
}
END_TEST

typedef struct Mistake
{
    const char* text;
    const char* expected;
} Mistake;

#define VERTEX3 "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACE1 "element face 1\nproperty list uchar int vertex_indices\n"
#define HEADER "ply\nformat ascii 1.0\n" VERTEX3 FACE1 "end_header\n"

static const Mistake s_plyMistakes[] = {
    {"", "the file is empty"},
    {"plx\n", "line 1: expected 'ply'"},
    {"ply", "the file ends inside the header"},
    {"ply\nformat ascii 1.0\nelement vertex 3", "line 3: the file ends inside the header"},
    {"ply\nformat ascii 2.0\nend_header\n", "line 2: expected 'format"},
    {"ply\nformat text 1.0\nend_header\n", "line 2: unknown format 'text'"},
    {"ply\n" VERTEX3 FACE1 "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "names no format"},
    {"ply\nformat ascii 1.0\nproperty float x\n", "line 3: a property before the first element"},
    {"ply\nformat ascii 1.0\nelement vertex\n", "line 3: expected 'element NAME COUNT'"},
    {"ply\nformat ascii 1.0\nelement vertex three\n", "line 3: 'three' is not a count"},
    {"ply\nformat ascii 1.0\nelement vertex -3\n", "line 3: '-3' is not a count"},
    {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n", "line 3: '99999999999999999999' is not a count"},
    {"ply\nformat ascii 1.0\nelement vertex 4294967296\n", "line 3: more than 4294967295 vertices"},
    {"ply\nformat ascii 1.0\n" VERTEX3 VERTEX3, "line 7: element vertex is declared twice"},
    {"ply\nformat ascii 1.0\n" VERTEX3 "property float x\n", "line 7: property x is declared twice"},
    {"ply\nformat ascii 1.0\nelement vertex 3\nproperty flaot x\n", "line 4: unknown type 'flaot'"},
    {"ply\nformat ascii 1.0\nelement vertex 3\nproperty float\n", "line 4: expected 'property"},
    {"ply\nformat ascii 1.0\n" VERTEX3 "element face 1\nproperty list float int vertex_indices\n",
     "line 8: the length of list vertex_indices is not of an integer type"},
    {"ply\nformat ascii 1.0\n" VERTEX3 "element face 1\nproperty list uchar float vertex_indices\n",
     "line 8: list vertex_indices is not of an integer type"},
    {"ply\nformat ascii 1.0\nelememt vertex 3\n", "line 3: unknown word 'elememt' in the header"},
    {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n" FACE1 "end_header\n0 0\n3 0 0 0\n",
     "no element vertex with properties x, y and z"},
    {"ply\nformat ascii 1.0\n" VERTEX3 "end_header\n0 0 0\n0 0 0\n0 0 0\n", "no element face with a list"},
    {"ply\nformat ascii 1.0\n" VERTEX3 "element polygon 1\nproperty list int int vertex_indices\nend_header\n"
     "0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n",
     "no element face with a list"},
    {"ply\nformat ascii 1.0\n" VERTEX3 FACE1 "element odd 1000000000\nend_header\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n",
     "line 9: element odd has no properties"},
    {"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n" FACE1
     "end_header\n0 0 0\n",
     "line 3: the file is too short for 4000000000 elements vertex"},
    {"ply\nformat ascii 1.0\n" VERTEX3 "element face 900000000000000000\nproperty list uchar int vertex_indices\n"
     "end_header\n0 0 0\n0 0 0\n0 0 0\n",
     "line 7: the file is too short for 900000000000000000 elements face"},
    {HEADER "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", "line 11: vertex 1: 'zero' is not a finite number"},
    {HEADER "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "line 11: vertex 1: 'nan' is not a finite number"},
    {HEADER "0 0 0\n1 0 1e39\n0 1 0\n3 0 1 2\n", "line 11: vertex 1: '1e39' is not a finite number"},
    {HEADER "0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 11: vertex 1: the line ends before the last value"},
    {HEADER "0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n", "line 11: vertex 1: '0' follows the last value"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 13: face 0: there is no vertex 3: the last is 2"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n", "line 13: face 0: there is no vertex -1"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n", "line 13: face 0: '1.5' is not an integer"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 4294967296 2\n", "line 13: face 0: '4294967296' is out of the range"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "line 13: face 0: fewer than 3 corners"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", "line 13: face 0: '-3' is out of the range"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "line 13: face 0: the line ends before"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0\n", "line 13: face 0: '0' follows the last value"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 1", "line 13: face 0: the file ends here"},
    {HEADER "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n\n3 2 1 0\n", "line 15: more data than the header declares"},
};

START_TEST(a_mistake_in_a_ply_file_is_named_with_its_line)
{
    const Mistake* mistake = &s_plyMistakes[_i];
    MustFail("a.ply", mistake->text, strlen(mistake->text), mistake->expected);
}
END_TEST

START_TEST(a_mistake_in_a_binary_file_is_named_with_its_element)
{
    for (Encoding encoding = encoding_little; encoding <= encoding_big; ++encoding)
    {
        for (int mistake = 0; mistake < 5; ++mistake)
        {
            static const char* expected[] = {
                "a.ply: vertex 1: a coordinate is not finite", "a.ply: face 0: there is no vertex 3: the last is 2",
                "a.ply: face 0: there is no vertex -2: the last is 2", "a.ply: face 0: fewer than 3 corners",
                "a.ply: more data than the header declares"};
            Bytes bytes;
            BeginPly(&bytes, encoding, VERTEX3 FACE1);
            for (int i = 0; i < 9; ++i)
                AddFloat(&bytes, mistake == 0 && i == 4 ? NAN : (float)i);
            AddInteger(&bytes, "uchar", mistake == 3 ? 2 : 3);
            AddInteger(&bytes, "int", 0);
            AddInteger(&bytes, "int", mistake == 1 ? 3 : mistake == 2 ? -2 : 1);
            AddInteger(&bytes, "int", 2);
            if (mistake == 4)
                AddInteger(&bytes, "int", 2);
            MustFail("a.ply", bytes.data, bytes.size, expected[mistake]);
        }
    }
}
END_TEST

static void BuildBinary(Bytes* bytes, Encoding encoding)
{
    BeginPly(bytes, encoding, VERTEX3 FACE1);
    for (int i = 0; i < 9; ++i)
        AddFloat(bytes, (float)i);
    AddInteger(bytes, "uchar", 3);
    for (int i = 0; i < 3; ++i)
        AddInteger(bytes, "int", i);
}

START_TEST(a_binary_file_is_refused_at_every_length_but_its_own)
{
    for (Encoding encoding = encoding_little; encoding <= encoding_big; ++encoding)
    {
        Bytes bytes;
        BuildBinary(&bytes, encoding);
        qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
        qcMesh_Free(&mesh);
        for (size_t size = 0; size < bytes.size; ++size)
            MustFail("a.ply", bytes.data, size, "");
    }
}
END_TEST

//  ---- OBJ -----------------------------------------------------------------------------------------

START_TEST(every_way_to_write_an_obj_corner_names_its_vertex)
{
    static const char text[] = "\xef\xbb\xbf# a comment that ends in a backslash \\\n"
                               "mtllib a.mtl\no name\nv 0 0 0\nv 1 0 0 1.0\n  v\t1 1 0 0.5 0.5 0.5 # white\r\n"
                               "vt 0 0\nvn 0 0 1\ng side\nusemtl red\ns off\nfoo 1 \\\nv 9 9 9\n"
                               "f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf 1/ 2// 3/1/\n"
                               "f -3 -2 -1\nf 1 \\\n2 \\\r\n 3\nf 1 2 3 4\nv 0 1 0\nf -1 -4 -3";
    qcMesh mesh = MustRead("a.OBJ", text, sizeof text - 1);
    ck_assert_uint_eq(mesh.vertexCount, 4);
    ck_assert(!mesh.isDouble);
    ck_assert_mem_eq(mesh.positions, ((const float[]){0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}), 12 * sizeof(float));
    AssertIndices(&mesh, 10, (const uint32_t[]){0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2,
                                                0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 2, 3, 3, 0, 1});
    qcMesh_Free(&mesh);
}
END_TEST

static const Mistake s_objMistakes[] = {
    {"", "no face in the file"},
    {"v 0 0 0\n", "no face in the file"},
    {"v 0 0 0\nv abc\n", "line 2: 'abc' is not a finite number"},
    {"v 0 0 0\nv 1 2\n", "line 2: a vertex with fewer than 3 coordinates"},
    {"v 0 0 0\nv 1 2 3 red\n", "line 2: 'red' is not a finite number"},
    {"v 0 0 inf\n", "line 1: 'inf' is not a finite number"},
    {"v 0 0 1e39\n", "line 1: '1e39' is not a finite number"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n", "line 4: face 1: there is no vertex 4: the last is 3"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 0 3\n", "line 5: '0' names vertex 0: the first is 1"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4: '-4' names a vertex that does not exist"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4294967296\n", "line 4: '4294967296' names a vertex that does not exist"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4294967295\n", "line 4: face 1: there is no vertex 4294967295"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "line 4: a face with fewer than 3 corners"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3x\n", "line 4: '3x' is not a corner of a face"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/a\n", "line 4: '3/a' is not a corner of a face"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/1/1/1\n", "line 4: '3/1/1/1' is not a corner of a face"},
    {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 /3\n", "line 4: '/3' is not a corner of a face"},
    {"v 0 0 0 \\\n\\\n\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n 1.5\n", "line 7: '1.5' is not a corner of a face"},
};

START_TEST(zeros_in_an_obj_file_are_named_with_their_line)
{
    static const char text[] = "\xef\xbb\xbfv 0 0 0\nv 1 0 0\n\0\0\0\0v 0 1 0\nv 5 5 5\nf 1 2 3\n";
    MustFail("a.obj", text, sizeof text - 1, "line 3: a byte of 0: the file is damaged, or no text");
}
END_TEST

START_TEST(a_mistake_in_an_obj_file_is_named_with_its_line)
{
    const Mistake* mistake = &s_objMistakes[_i];
    MustFail("a.obj", mistake->text, strlen(mistake->text), mistake->expected);
}
END_TEST

//  ---- files ---------------------------------------------------------------------------------------

START_TEST(a_file_that_is_no_mesh_is_refused_by_name)
{
    qcMesh mesh;
    qcMessage message;
    ck_assert(!qcMesh_ReadFile("there/is/no.ply", qc_meshAsDeclared, &mesh, &message));
    ck_assert_str_eq(message.text, "there/is/no.ply: No such file or directory");
    ck_assert(!qcMesh_ReadFile("/", qc_meshAsDeclared, &mesh, &message));
    ck_assert_str_eq(message.text, "/: Is a directory");
    MustFail("a.stl", "solid", 5, "a.stl: not a mesh");
}
END_TEST

START_TEST(a_file_on_disk_is_read_as_its_bytes_are)
{
    // Longer than the reader's first block.
    enum
    {
        faceCount = 20000
    };
    const char* path = "faces.obj";
    EnterFolder();
    FILE* stream = fopen(path, "w");
    ck_assert_ptr_nonnull(stream);
    fprintf(stream, "v 0 0 0\nv 1 0 0\nv 0 1 0.5\n");
    for (int i = 0; i < faceCount; ++i)
        fprintf(stream, "f 1 2 3\n");
    ck_assert_int_eq(fclose(stream), 0);
    qcMesh mesh;
    qcMessage message;
    bool read = qcMesh_ReadFile(path, qc_meshAsDeclared, &mesh, &message);
    LeaveFolder();
    ck_assert_msg(read, "%s", message.text);
    ck_assert_uint_eq(mesh.triangleCount, faceCount);
    ck_assert_uint_eq(mesh.indices[3 * faceCount - 1], 2);
    qcMesh_Free(&mesh);
}
END_TEST

START_TEST(with_doubles_requested_all_digits_of_a_text_are_used)
{
    static const char* const texts[][2] = {
        {"a.obj", "v 10000000.1 1e300 -0.1\nv 0 0 0\nv 1 1 1\nf 1 2 3\n"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                  "10000000.1 1e300 -0.1\n0 0 0\n1 1 1\n3 0 1 2\n"}};
    for (int i = 0; i < 2; ++i)
    {
        qcMesh mesh;
        qcMessage message;
        const char *name = texts[i][0], *text = texts[i][1];
        ck_assert_msg(ReadAs(qc_meshDouble, name, text, strlen(text), &mesh, &message), "%s", message.text);
        ck_assert(mesh.isDouble);
        ck_assert_mem_eq(mesh.positions, ((const double[]){10000000.1, 1e300, -0.1, 0, 0, 0, 1, 1, 1}),
                         9 * sizeof(double));
        AssertIndices(&mesh, 1, (const uint32_t[]){0, 1, 2});
        qcMesh_Free(&mesh);
        MustFail(name, text, strlen(text), "'1e300' is not a finite number");
    }
}
END_TEST

START_TEST(with_doubles_requested_binary_floats_become_doubles)
{
    for (Encoding encoding = encoding_little; encoding <= encoding_big; ++encoding)
    {
        Bytes bytes;
        BuildBinary(&bytes, encoding);
        qcMesh mesh;
        qcMessage message;
        ck_assert_msg(ReadAs(qc_meshDouble, "a.ply", bytes.data, bytes.size, &mesh, &message), "%s", message.text);
        ck_assert(mesh.isDouble);
        for (int i = 0; i < 9; ++i)
            ck_assert_double_eq(((double*)mesh.positions)[i], i);
        qcMesh_Free(&mesh);
        ck_assert(!ReadAs(qc_meshDouble, "a.ply", bytes.data, bytes.size - 1, &mesh, &message));
        ck_assert_ptr_null(mesh.positions);
    }
}
END_TEST

//  ---- damage --------------------------------------------------------------------------------------

/// A reader may refuse damaged bytes or read them; a mesh that it returns is always valid.
static void AssertSoundOrRefused(const char* name, const char* data, size_t size)
{
    qcMesh mesh;
    qcMessage message = {""};
    if (!Read(name, data, size, &mesh, &message))
    {
        ck_assert_ptr_nonnull(strstr(message.text, name));
        return;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh.triangleCount; ++i)
        ck_assert_uint_lt(mesh.indices[i], mesh.vertexCount);
    for (size_t i = 0; i < 3 * (size_t)mesh.vertexCount; ++i)
        ck_assert(isfinite(mesh.isDouble ? ((double*)mesh.positions)[i] : ((float*)mesh.positions)[i]));
    qcMesh_Free(&mesh);
}

START_TEST(damaged_files_are_refused_or_give_valid_meshes)
{
    static Bytes originals[4];
    BuildBinary(&originals[0], encoding_ascii);
    BuildBinary(&originals[1], encoding_little);
    BuildBinary(&originals[2], encoding_big);
    originals[3].size = 0;
    AddText(&originals[3], "v 0 0 0\nv 1.5e0 0 -.5\nv 0 1 0 # c\nvt 0 0\nf 1/1 2/1 3/1 -3\nf -1 \\\n-2 -3\n");
    srand(3);
    for (int original = 0; original < 4; ++original)
    {
        const Bytes* bytes = &originals[original];
        const char* name = original < 3 ? "a.ply" : "a.obj";
        for (size_t size = 0; size <= bytes->size; ++size)
            AssertSoundOrRefused(name, bytes->data, size);
        for (int round = 0; round < 20000; ++round)
        {
            char damaged[1024];
            size_t size = bytes->size;
            memcpy(damaged, bytes->data, size);
            for (int flips = 1 + rand() % 3; flips > 0; --flips)
            {
                static const char likely[] = "0123456789-+.e/\\#\n\r \t\0\xff";
                size_t place = (size_t)rand() % size;
                damaged[place] = rand() % 2 ? likely[(size_t)rand() % (sizeof likely - 1)] : (char)(rand() % 256);
            }
            AssertSoundOrRefused(name, damaged, size);
        }
    }
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("mesh_file");
    TCase* ply = tcase_create("ply");
    tcase_add_test(ply, every_encoding_gives_the_same_mesh);
    tcase_add_test(ply, positions_are_doubles_where_a_float_would_lose_bits);
    tcase_add_test(ply, doubles_keep_all_their_bits);
    tcase_add_test(ply, unknown_elements_properties_and_lists_are_skipped);
    tcase_add_test(ply, a_polygon_is_a_fan_around_its_first_corner);
    tcase_add_test(ply, line_ends_blank_lines_and_the_last_newline_do_not_matter);
    tcase_add_loop_test(ply, a_mistake_in_a_ply_file_is_named_with_its_line, 0,
                        sizeof s_plyMistakes / sizeof s_plyMistakes[0]);
    tcase_add_test(ply, a_mistake_in_a_binary_file_is_named_with_its_element);
    tcase_add_test(ply, a_binary_file_is_refused_at_every_length_but_its_own);
    suite_add_tcase(suite, ply);
    TCase* obj = tcase_create("obj");
    tcase_add_test(obj, every_way_to_write_an_obj_corner_names_its_vertex);
    tcase_add_test(obj, zeros_in_an_obj_file_are_named_with_their_line);
    tcase_add_loop_test(obj, a_mistake_in_an_obj_file_is_named_with_its_line, 0,
                        sizeof s_objMistakes / sizeof s_objMistakes[0]);
    suite_add_tcase(suite, obj);
    TCase* files = tcase_create("files");
    tcase_add_test(files, a_file_that_is_no_mesh_is_refused_by_name);
    tcase_add_test(files, a_file_on_disk_is_read_as_its_bytes_are);
    tcase_add_test(files, with_doubles_requested_all_digits_of_a_text_are_used);
    tcase_add_test(files, with_doubles_requested_binary_floats_become_doubles);
    suite_add_tcase(suite, files);
    TCase* damage = tcase_create("damage");
    tcase_add_test(damage, damaged_files_are_refused_or_give_valid_meshes);
    tcase_set_timeout(damage, 60);
    suite_add_tcase(suite, damage);
    return qcRunSuite(suite);
}
