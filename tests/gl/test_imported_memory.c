// Positions in memory that Vulkan has allocated, imported by a file descriptor: the same pairs as those of the CPU.
#define _GNU_SOURCE // dladdr
#include "quickcullide/quickcullide.h"
#include "support/check_ok.h"
#include "support/devices.h"
#include "support/soups.h"
#include "support/suite.h"

#include <dlfcn.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

/// An allocation that another API can import, mapped.
typedef struct Exported
{
    VkInstance instance;
    VkDevice device;
    VkDeviceMemory memory;
    float* positions;
    VkDeviceSize size;
    int fd;
} Exported;

enum
{
    t_offset = 256 ///< bytes before the positions
};

static uint32_t FindMappedType(VkPhysicalDevice gpu)
{
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(gpu, &types);
    for (uint32_t i = 0; i < types.memoryTypeCount; i++)
        if ((types.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) != 0)
            return i;
    return 0;
}

/// False, after a line of output, if Vulkan does not do that here.
static bool Export(Exported* e, VkDeviceSize size)
{
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_1};
    const VkInstanceCreateInfo instanceInfo = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                               .pApplicationInfo = &application};
    const char* extension = VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME;
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
    const VkDeviceCreateInfo deviceInfo = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                           .queueCreateInfoCount = 1,
                                           .pQueueCreateInfos = &queue,
                                           .enabledExtensionCount = 1,
                                           .ppEnabledExtensionNames = &extension};
    uint32_t count = 1;
    VkPhysicalDevice gpu = VK_NULL_HANDLE;
    *e = (Exported){.fd = -1, .size = size};
    bool opened = vkCreateInstance(&instanceInfo, NULL, &e->instance) == VK_SUCCESS &&
                  vkEnumeratePhysicalDevices(e->instance, &count, &gpu) >= 0 && count == 1 &&
                  vkCreateDevice(gpu, &deviceInfo, NULL, &e->device) == VK_SUCCESS;
    if (!opened)
    {
        printf("skipped: no Vulkan with VK_KHR_external_memory_fd\n");
        return false;
    }
    const VkExportMemoryAllocateInfo exported = {.sType = VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO,
                                                 .handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT};
    const VkMemoryAllocateInfo allocation = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                             .pNext = &exported,
                                             .allocationSize = size,
                                             .memoryTypeIndex = FindMappedType(gpu)};
    const VkMemoryGetFdInfoKHR get = {.sType = VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR,
                                      .handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT};
    VkMemoryGetFdInfoKHR getFd = get;
    PFN_vkGetMemoryFdKHR getMemoryFd = (PFN_vkGetMemoryFdKHR)vkGetDeviceProcAddr(e->device, "vkGetMemoryFdKHR");
    void* mapped = NULL;
    ck_assert_int_eq(vkAllocateMemory(e->device, &allocation, NULL, &e->memory), VK_SUCCESS);
    ck_assert_int_eq(vkMapMemory(e->device, e->memory, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
    getFd.memory = e->memory;
    ck_assert_int_eq(getMemoryFd(e->device, &getFd, &e->fd), VK_SUCCESS);
    e->positions = (float*)((char*)mapped + t_offset);
    return true;
}

/// The driver stays loaded when the last instance goes, so that a leak of its own has its name in the report.
static void KeepDriverLoaded(const Exported* e)
{
    Dl_info driver;
    PFN_vkVoidFunction function = vkGetDeviceProcAddr(e->device, "vkAllocateMemory");
    if (dladdr(*(void**)&function, &driver) != 0)
        dlopen(driver.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
}

static void Release(Exported* e)
{
    KeepDriverLoaded(e);
    close(e->fd);
    vkFreeMemory(e->device, e->memory, NULL);
    vkDestroyDevice(e->device, NULL);
    vkDestroyInstance(e->instance, NULL);
}

static qcScene* MakeScene(qcDevice* device, const qcSoup* soup, qcBodyId* id)
{
    qcScene* scene;
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = device;
    CHECK_OK(qcScene_Create(&sceneDef, &scene));
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = soup->positions;
    def.positionType = qc_positionF64;
    def.vertexCount = soup->vertexCount;
    def.indices = soup->indices;
    def.triangleCount = soup->triangleCount;
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(scene, &def, id));
    return scene;
}

static void CheckSteps(Exported* e, const qcSoup* soup, qcDevice* device, qcDeviceBuffer* buffer)
{
    qcBodyId ids[2];
    qcScene *onDevice = MakeScene(device, soup, &ids[0]), *onCpu = MakeScene(NULL, soup, &ids[1]);
    qcVertexBufferDef vertices = qcDefaultVertexBufferDef();
    vertices.buffer = buffer;
    qcDetectDef layers = qcDefaultDetectDef(), sweep = layers;
    layers.method = qc_methodLayers;
    for (uint64_t step = 0; step < 3; step++)
    {
        const qcResult *result, *expected;
        qcRandom random = {step};
        for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
            e->positions[i] = (float)(soup->positions[i] + qcRandom_Uniform(&random, -0.004, 0.004));
        CHECK_OK(qcScene_SetVertexBuffer(onDevice, ids[0], &vertices));
        CHECK_OK(qcScene_SetVertices(onCpu, ids[1], e->positions, qc_positionF32, 0));
        CHECK_OK(qcScene_Detect(onDevice, &layers, &result));
        CHECK_OK(qcScene_Detect(onCpu, &sweep, &expected));
        ck_assert_int_eq(result->profile.method, qc_methodLayers);
        ck_assert_uint_gt(result->pairCount, 10);
        ck_assert_uint_eq(result->pairCount, expected->pairCount);
        ck_assert_mem_eq(result->pairs, expected->pairs, sizeof(qcPair) * result->pairCount);
    }
    qcScene_Destroy(onDevice);
    qcScene_Destroy(onCpu);
}

START_TEST(memory_of_vulkan_gives_the_pairs_of_the_cpu_or_a_message)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(5, 40, 0.02, 0.011);
    Exported exported;
    // A whole number of pages, and some bytes at the end that llvmpipe does not give.
    VkDeviceSize size = (t_offset + 3 * sizeof(float) * soup.vertexCount + 64 + 4095) / 4096 * 4096;
    if (Export(&exported, size))
    {
        QC_FOR_EACH_DEVICE(device)
        {
            qcDeviceBufferDef def = qcDefaultDeviceBufferDef();
            def.memoryFd = exported.fd;
            def.memorySize = exported.size;
            def.memoryOffset = t_offset;
            qcDeviceBuffer* buffer = NULL;
            qcStatus status = qcDevice_OpenBuffer(device, &def, &buffer);
            if (status == qc_statusOk)
            {
                CheckSteps(&exported, &soup, device, buffer);
                printf("memory is imported\n");
            }
            else
            {
                ck_assert_int_eq(status, qc_statusDevice);
                ck_assert_ptr_nonnull(strstr(qcLastMessage(), "can't import"));
                printf("skipped: %s\n", qcLastMessage());
            }
            qcDeviceBuffer_Close(buffer);
        }
        Release(&exported);
    }
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("imported memory", memory_of_vulkan_gives_the_pairs_of_the_cpu_or_a_message)
