// Triangle strips in PLY files: their triangles, and the positions that errors name.
#include "tools/mesh_bytes.h"
#include "support/suite.h"

#define VERTICES "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define LIST "element tristrips 1\nproperty list int int vertex_indices\n"
#define STRIPS "ply\nformat ascii 1.0\n" VERTICES LIST "end_header\n0 0 0\n1 0 0\n0 1 0\n"

START_TEST(strips_give_their_triangles_wound_alike_in_every_encoding)
{
    // Two triangles; a strip stitched with a repeated vertex; an empty one; a single triangle; the end.
    static const int strips[] = {0, 1, 2, 3, -1, 1, 2, 2, 3, 0, 1, -1, -1, 3, 1, 0, -1};
    static const uint32_t indices[] = {0, 1, 2, 2, 1, 3, 2, 3, 0, 0, 3, 1, 3, 1, 0, 0, 2, 3, 0, 3, 3};
    static const char* const types[][2] = {{"int", "int"}, {"uchar", "short"}, {"uint", "char"}};
    enum
    {
        count = sizeof strips / sizeof strips[0]
    };
    for (Encoding encoding = 0; encoding < encoding_count; ++encoding)
        for (int t = 0; t < 3; ++t)
        {
            Bytes bytes;
            char declarations[512];
            // A list beside the strips, another list of strips that is empty, and faces behind them.
            snprintf(declarations, sizeof declarations,
                     "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                     "element tristrips 2\nproperty list uchar float other\nproperty list %s %s vertex_indices\n"
                     "element face 2\nproperty list uchar int vertex_indices\n",
                     types[t][0], types[t][1]);
            BeginPly(&bytes, encoding, declarations);
            for (int i = 0; i < 4; ++i)
            {
                for (int axis = 0; axis < 3; ++axis)
                    AddFloat(&bytes, (float)(i + axis));
                EndElement(&bytes);
            }
            AddInteger(&bytes, "uchar", 1);
            AddFloat(&bytes, 0.5f);
            AddInteger(&bytes, types[t][0], count);
            for (int i = 0; i < count; ++i)
                AddInteger(&bytes, types[t][1], strips[i]);
            EndElement(&bytes);
            AddInteger(&bytes, "uchar", 0);
            AddInteger(&bytes, types[t][0], 0);
            EndElement(&bytes);
            for (int i = 0; i < 2; ++i)
            {
                AddInteger(&bytes, "uchar", 3);
                for (int corner = 0; corner < 3; ++corner)
                    AddInteger(&bytes, "int", indices[15 + 3 * i + corner]);
                EndElement(&bytes);
            }
            qcMesh mesh = MustRead("a.ply", bytes.data, bytes.size);
            ck_assert_uint_eq(mesh.vertexCount, 4);
            AssertIndices(&mesh, 7, indices);
            qcMesh_Free(&mesh);
            // Cut off anywhere behind the header it is refused.
            if (encoding != encoding_ascii)
                MustFail("a.ply", bytes.data, bytes.size - 1, "the file ends here");
        }
}
END_TEST

START_TEST(strips_alone_are_a_mesh)
{
    static const char text[] = STRIPS "3 0 1 2\n";
    static const uint32_t indices[] = {0, 1, 2};
    qcMesh mesh = MustRead("a.ply", text, sizeof text - 1);
    AssertIndices(&mesh, 1, indices);
    qcMesh_Free(&mesh);
}
END_TEST

START_TEST(a_bad_strip_in_a_binary_file_is_named_by_its_position)
{
    for (Encoding encoding = encoding_little; encoding < encoding_count; ++encoding)
    {
        Bytes bytes;
        BeginPly(&bytes, encoding,
                 "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                 "element tristrips 1\nproperty list int int vertex_indices\n");
        for (int axis = 0; axis < 3; ++axis)
            AddFloat(&bytes, 0.0f);
        static const int values[] = {5, 0, 0, 0, -1, 1};
        for (int i = 0; i < 6; ++i)
            AddInteger(&bytes, "int", values[i]);
        MustFail("a.ply", bytes.data, bytes.size, "a.ply: tristrips 0: value 5: there is no vertex 1: the last is 0");
        MustFail("a.ply", bytes.data, bytes.size - 4, "a.ply: tristrips 0: value 5: the file ends here");
    }
}
END_TEST

typedef struct Mistake
{
    const char* text;
    const char* expected;
} Mistake;

START_TEST(a_mistake_in_a_strip_is_named_with_its_line_and_position)
{
    static const Mistake mistakes[] = {
        {"ply\nformat ascii 1.0\n" VERTICES "element tristrips 1\nproperty list int int strips\nend_header\n"
         "0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n",
         "no element face with a list vertex_indices, and no tristrips with one"},
        {"ply\nformat ascii 1.0\n" VERTICES LIST LIST, "line 9: element tristrips is declared twice"},
        {"ply\nformat ascii 1.0\n" VERTICES "element tristrips 1\nproperty list int float vertex_indices\n",
         "line 8: list vertex_indices is not of an integer type"},
        {STRIPS "6 0 1 2 -1 0 3\n", "line 13: tristrips 0: value 6: there is no vertex 3: the last is 2"},
        {STRIPS "4 0 1 2 -2\n", "line 13: tristrips 0: value 4: there is no vertex -2: the last is 2"},
        {STRIPS "6 0 1 -1 0 1 2\n", "line 13: tristrips 0: value 3: a strip of fewer than 3 vertices ends here"},
        {STRIPS "5 0 1 2 -1 0\n", "line 13: tristrips 0: value 5: a strip of fewer than 3 vertices ends here"},
        {STRIPS "4 0 1 2\n", "line 13: tristrips 0: value 4: the line ends before the last value"},
        {STRIPS "3 0 1 2 0\n", "line 13: tristrips 0: '0' follows the last value"},
        {STRIPS "3 0 1 x\n", "line 13: tristrips 0: value 3: 'x' is not an integer"},
        {STRIPS "-1\n", "line 13: tristrips 0: a list of negative length"},
    };
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; ++i)
        MustFail("a.ply", mistakes[i].text, strlen(mistakes[i].text), mistakes[i].expected);
}
END_TEST

QC_RUN_TESTS("mesh strips", strips_give_their_triangles_wound_alike_in_every_encoding, strips_alone_are_a_mesh,
             a_bad_strip_in_a_binary_file_is_named_by_its_position,
             a_mistake_in_a_strip_is_named_with_its_line_and_position)
